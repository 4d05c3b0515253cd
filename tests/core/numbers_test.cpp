#include <gpsrecon/core/numbers.h>

#include <gtest/gtest.h>
#include <cmath>
#include <cstdio>
#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

TEST(ToText, ReadsBackAsTheSameNumber) {
  test::Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const double value = std::ldexp(random.uniform(-1, 1), static_cast<int>(random.uniform(-300, 300)));
    EXPECT_EQ(parse_double(to_text(value)), value);
  }
  EXPECT_EQ(to_text(0.1), "0.1");
  EXPECT_EQ(parse_point(to_text(Vec3(1, -0.25, 3e100))), Vec3(1, -0.25, 3e100));
}

/// As the C library prints it.
TEST(Number, IsRoundedToItsDigits) {
  test::Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const double value = std::ldexp(random.uniform(-1, 1), static_cast<int>(random.uniform(-60, 60)));
    for (const int digits : {1, 4, 9}) {
      char text[64];
      std::snprintf(text, sizeof text, "%.*g", digits, value);
      EXPECT_EQ(number(value, digits), text);
    }
  }
  EXPECT_EQ(number(12.5), "12.5");
  EXPECT_EQ(number(123456), "1.235e+05");
}

TEST(CountOf, KnowsOneFromMany) {
  EXPECT_EQ(count_of(0, "face"), "0 faces");
  EXPECT_EQ(count_of(1, "face"), "1 face");
  EXPECT_EQ(count_of(2, "face"), "2 faces");
}

}  // namespace
}  // namespace gpsrecon
