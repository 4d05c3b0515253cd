#include <gpsrecon/core/options.h>

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gtest/gtest.h>
#include <array>
#include <limits>

namespace gpsrecon {
namespace {

enum class Colour { red, green };
constexpr std::array<std::string_view, 2> option_names(Colour /*type*/) {
  return {"red", "deep-green"};
}

struct Options {
  int count = 3;
  double share = 0.5;
  std::size_t budget = 0;
  bool fast = false;
  Colour colour = Colour::red;
  std::optional<int> level = {};
  std::optional<Vec3> place = {};
  Length width = {};
  Length limit = Length::of_diagonal(0.01);
  std::vector<std::string> names = {};

  static OptionTable fields() {
    return {field<&Options::count>("count", "[0, 8]", "how many"),
            field<&Options::share>("share", "(0, 1)", "how much"),
            field<&Options::budget>("budget", ">= 4 or 0", "at most"),
            field<&Options::fast>("fast", "", "hurry"),
            field<&Options::colour>("colour", "", "which"),
            field<&Options::level>("level", "[0, 8]", "how deep").or_else("auto"),
            field<&Options::place>("place", "", "where").or_else("unknown"),
            field<&Options::width>("width", "> 0", "how wide"),
            field<&Options::limit>("limit", "> 0", "how far"),
            field<&Options::names>("names", "", "who")};
  }
  void check() const { check_fields(*this); }
};

const Field& row(std::string_view name) {
  static const OptionTable table = Options::fields();
  for (const Field& field : table)
    if (field.name == name) return field;
  throw std::logic_error("no such row");
}

/// What check() says after `text` was read into the option.
std::string complaint(std::string_view name, const std::string& text) {
  Options options;
  row(name).set(&options, text);
  try {
    options.check();
  } catch (const OptionError& error) {
    return error.what();
  }
  return "";
}

TEST(OptionTable, DefaultsAreInRange) {
  EXPECT_NO_THROW(Options{}.check());
}

TEST(OptionTable, TextIsReadIntoTheMemberAndBack) {
  Options options;
  for (const auto& [name, text] : std::vector<std::pair<const char*, const char*>>{{"count", "7"},
                                                                                   {"share", "0.1"},
                                                                                   {"budget", "900"},
                                                                                   {"fast", "true"},
                                                                                   {"colour", "deep-green"},
                                                                                   {"level", "0"},
                                                                                   {"place", "1,-2.5,3"},
                                                                                   {"width", "2sp"},
                                                                                   {"limit", "0.5"},
                                                                                   {"names", "a,b"}}) {
    row(name).set(&options, text);
    EXPECT_EQ(row(name).state(&options).text, text) << name;
  }
  EXPECT_EQ(options.count, 7);
  EXPECT_EQ(options.share, 0.1);
  EXPECT_EQ(options.budget, 900);
  EXPECT_TRUE(options.fast);
  EXPECT_EQ(options.colour, Colour::green);
  EXPECT_EQ(options.level, 0);
  EXPECT_EQ(options.place, Vec3(1, -2.5, 3));
  EXPECT_EQ(options.width, Length::spacings(2));
  EXPECT_EQ(options.limit, Length::scene(0.5));
  EXPECT_EQ(options.names, (std::vector<std::string>{"a", "b"}));
}

TEST(OptionTable, TheWordForNoValueTakesItAway) {
  Options options{.level = 2, .place = Vec3(1, 2, 3), .width = Length::scene(1), .names = {"a"}};
  for (const auto& [name, word] : std::vector<std::pair<const char*, const char*>>{
           {"level", "auto"}, {"place", "unknown"}, {"width", "auto"}, {"names", "none"}}) {
    row(name).set(&options, word);
    EXPECT_EQ(row(name).state(&options).text, word);
  }
  EXPECT_EQ(options.level, std::nullopt);
  EXPECT_EQ(options.place, std::nullopt);
  EXPECT_TRUE(options.width.is_automatic());
  EXPECT_TRUE(options.names.empty());
}

TEST(OptionTable, EndsOfRangesAreOpenOrClosed) {
  for (const char* good : {"0", "8"}) EXPECT_EQ(complaint("count", good), "");
  EXPECT_EQ(complaint("count", "-1"), "count must be in [0, 8], not -1");
  EXPECT_EQ(complaint("count", "9"), "count must be in [0, 8], not 9");
  for (const char* good : {"1e-300", "0.9999999999999999"}) EXPECT_EQ(complaint("share", good), "");
  for (const char* bad : {"0", "1"})
    EXPECT_EQ(complaint("share", bad), std::string("share must be in (0, 1), not ") + bad);
  for (const char* good : {"0", "4", "5"}) EXPECT_EQ(complaint("budget", good), "");
  EXPECT_EQ(complaint("budget", "3"), "budget must be >= 4 or 0, not 3");
  EXPECT_EQ(complaint("level", "9"), "level must be in [0, 8] or auto, not 9");
  EXPECT_EQ(complaint("width", "0%"), "width must be > 0 or auto, not 0%");
  EXPECT_EQ(complaint("limit", "-1sp"), "limit must be > 0, not -1sp");
}

TEST(OptionTable, ALengthWithADefaultIsNeverAutomatic) {
  EXPECT_EQ(complaint("limit", "auto"), "limit must be > 0, not auto");
}

TEST(OptionTable, NumbersAreFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((Options{.share = bad}.check()), OptionError);
    EXPECT_THROW((Options{.place = Vec3(0, bad, 0)}.check()), OptionError);
    EXPECT_THROW((Options{.width = Length::scene(bad)}.check()), OptionError);
  }
}

TEST(OptionTable, SaysWhatWasExpected) {
  struct Case {
    const char *name, *text, *expected;
  };
  for (const Case& c : std::vector<Case>{{"count", "1.5", "an integer"},
                                         {"count", "99999999999", "a smaller integer"},
                                         {"budget", "-1", "an integer >= 0"},
                                         {"share", "0,5", "a number"},
                                         {"fast", "maybe", "true or false"},
                                         {"colour", "blue", "one of red|deep-green"},
                                         {"place", "1,2", "three numbers X,Y,Z"},
                                         {"place", "1,2,3,", "three numbers X,Y,Z"}}) {
    Options options;
    try {
      row(c.name).set(&options, c.text);
      ADD_FAILURE() << c.name << " takes " << c.text;
    } catch (const OptionError& error) {
      EXPECT_EQ(error.what(), std::string("expected ") + c.expected + ", got '" + c.text + "'");
    }
  }
}

TEST(OptionTable, ReportsHoldValuesOfTheirTypes) {
  const auto values = option_values(Options{});
  EXPECT_EQ(values.size(), 10);
  EXPECT_EQ(values.at("count"), OptionValue(std::int64_t{3}));
  EXPECT_EQ(values.at("share"), OptionValue(0.5));
  EXPECT_EQ(values.at("fast"), OptionValue(false));
  EXPECT_EQ(values.at("colour"), OptionValue("red"));
  EXPECT_EQ(values.at("level"), OptionValue("auto"));
  EXPECT_EQ(values.at("limit"), OptionValue("1%"));
}

}  // namespace
}  // namespace gpsrecon
