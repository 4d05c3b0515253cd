#include <gpsrecon/core/length.h>

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gtest/gtest.h>
#include <cmath>

#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

using testing::HasSubstr;
using testing::Property;

TEST(Length, IsReadInEachUnit) {
  EXPECT_TRUE(Length::parse("auto").is_automatic());
  EXPECT_EQ(Length::parse("0.1%"), Length::of_diagonal(0.001));
  EXPECT_EQ(Length::parse("2sp"), Length::spacings(2));
  EXPECT_EQ(Length::parse("0.2"), Length::scene(0.2));
  EXPECT_EQ(Length::parse("1e-3%"), Length::of_diagonal(1e-5));
}

TEST(Length, IsPrintedAsItWasSpelled) {
  for (const char* text : {"auto", "0.1%", "2sp", "0.2", "100%", "12.5%", "0.0025%", "0.003%", "1e-09%", "7%", "0.5sp"})
    EXPECT_EQ(Length::parse(text).text(), text == std::string("1e-09%") ? "1e-9%" : text);
}

TEST(Length, IsReadBackAsTheSameFromItsText) {
  test::Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const double number = std::exp(60 * (random.uniform() - 0.5)) * (i % 2 == 0 ? 1 : -1);
    for (const Length& length : {Length::of_diagonal(number), Length::spacings(number), Length::scene(number)})
      ASSERT_EQ(Length::parse(length.text()), length) << length.text();
  }
}

TEST(Length, SharesSpelledInPercentAreTheDecimalNumber) {
  // 0.07 / 100 is another double than 0.0007: the point is moved in the text.
  for (int i = 1; i < 1000; ++i) {
    const std::string digits = std::to_string(i);
    EXPECT_EQ(Length::parse(digits + "e-4%").number(), std::stod(digits + "e-6"));
  }
}

TEST(Length, RefusesWhatIsNoLength) {
  for (const char* text : {"", "%", "sp", "1 %", "0,1%", "1e%", "nan", "inf%", "2spp", "1e400", "0x1p3", "automatic"})
    EXPECT_THROW(Length::parse(text), OptionError) << text;
}

TEST(Length, ResolvesToTheUnitsOfThePositions) {
  const LengthScale scale{.diagonal = 1.5, .spacing = 0.01, .scene_to_local = 0.125};
  EXPECT_EQ(Length::of_diagonal(0.5).resolve(scale, "x"), 0.75);
  EXPECT_EQ(Length::spacings(3).resolve(scale, "x"), 3 * 0.01);
  EXPECT_EQ(Length::scene(4).resolve(scale, "x"), 0.5);
  EXPECT_EQ(Length().resolve(scale, "x", 7), 7);
}

TEST(Length, SaysWhatItWouldNeed) {
  const auto fails = [](const Length& length) { length.resolve({}, "sigma0"); };
  EXPECT_THAT([&] { fails(Length::spacings(2)); },
              testing::Throws<OptionError>(
                  Property(&OptionError::what, HasSubstr("sigma0: 2sp refers to the sample spacing of points"))));
  EXPECT_THAT(
      [&] { fails(Length::of_diagonal(0.02)); },
      testing::Throws<OptionError>(Property(&OptionError::what, HasSubstr("sigma0: 2% refers to the diagonal"))));
}

}  // namespace
}  // namespace gpsrecon
