#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/report/heatmap.h>
#include <gpsrecon/report/html_report.h>
#include <gpsrecon/report/picture.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/meshes.h"

// Errors to look at: colours, picture, page.

namespace gpsrecon::test {

using namespace internal;
namespace {

using testing::HasSubstr;
using testing::Not;

double lightness(const Color& c) {  // CIE L*, of sRGB
  const auto linear = [](double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); };
  const double y = 0.2126 * linear(c[0] / 255.0) + 0.7152 * linear(c[1] / 255.0) + 0.0722 * linear(c[2] / 255.0);
  return 116 * std::cbrt(y) - 16;
}

TEST(Palette, UnsignedGrowsLighterInEvenSteps) {
  const std::vector<Color> colors = palette(false, 33);
  const double step = (lightness(colors.back()) - lightness(colors.front())) / 32;
  EXPECT_GT(step, 2);
  for (std::size_t i = 1; i < colors.size(); ++i)
    EXPECT_NEAR(lightness(colors[i]) - lightness(colors[i - 1]), step, 0.6 * step) << i;
}

TEST(Palette, SignedIsWhiteInTheMiddleAndAsDarkAtBothEnds) {
  const std::vector<Color> colors = palette(true, 33);
  EXPECT_GT(lightness(colors[16]), 95);
  for (std::size_t i = 1; i <= 16; ++i) {
    EXPECT_GT(lightness(colors[i]), lightness(colors[i - 1]));
    EXPECT_LT(lightness(colors[16 + i]), lightness(colors[15 + i]));
    EXPECT_NEAR(lightness(colors[16 - i]), lightness(colors[16 + i]), 7);
  }
  EXPECT_GT(colors.front()[2], colors.front()[0]);  // blue inside
  EXPECT_GT(colors.back()[0], colors.back()[2]);    // red outside
}

TEST(ErrorMap, SignedDistancesOfTheVertices) {
  const ErrorMap above = error_map(square(0.1), square(0)), below = error_map(square(-0.2), square(0), 0.8);
  EXPECT_TRUE(above.is_signed);
  for (const double e : above.errors) EXPECT_DOUBLE_EQ(e, 0.1);
  for (const double e : below.errors) EXPECT_DOUBLE_EQ(e, -0.2);
  EXPECT_DOUBLE_EQ(above.range, 0.1);
  EXPECT_DOUBLE_EQ(below.range, 0.8);
  const std::vector<Color> colors = palette(true, 255);
  EXPECT_EQ(colored(square(0.1), above).colors[0], colors.back());
  EXPECT_EQ(colored(square(-0.2), below).colors[0], colors[95]);  // (1 - 0.2 / 0.8) / 2 of 254
  EXPECT_EQ(colored(square(0.1), above).scalars.at(0).name, "signed_error");
}

TEST(ErrorMap, MeanDistanceOfThePointsAtAVertexAndGreyWhereThereAreNone) {
  Mesh mesh = square(0);
  mesh.faces = {};
  mesh.faces.add(0, 1, 2);
  mesh.faces.add(0, 2, 3);
  PointCloud cloud;
  cloud.positions = {{0.9, 0.1, 0.2}, {0.8, 0.1, -0.4}};  // both on the first triangle
  cloud.weights = {3, 1};
  const ErrorMap map = error_map(mesh, cloud);
  for (const Index v : {0U, 1U, 2U}) EXPECT_DOUBLE_EQ(map.errors[v], (3 * 0.2 + 0.4) / 4);
  EXPECT_TRUE(std::isnan(map.errors[3]));
  EXPECT_FALSE(map.is_signed);
  EXPECT_EQ(colored(mesh, map).colors[3], no_error_color);
  EXPECT_EQ(colored(mesh, map).colors[0], palette(false, 255).back());
}

TEST(ErrorMap, ScaleIsThatOfTheScene) {
  Mesh high = square(0.1), low = square(0);
  high.frame.exponent = low.frame.exponent = 3;
  EXPECT_DOUBLE_EQ(error_map(high, low).errors[0], 0.8);
  EXPECT_THROW(error_map(high, square(0)), InvariantError);
}

TEST(Picture, ABallIsADiscAsLargeAsFits) {
  Mesh ball = sphere(5);
  ball.colors.assign(ball.positions.size(), Color{255, 0, 0});
  const Picture picture = draw(ball, {Vec3::UnitX(), Vec3::UnitZ()}, 200, 100);
  std::size_t red = 0;
  for (std::size_t y = 0; y < 100; ++y)
    for (std::size_t x = 0; x < 200; ++x) {
      const Color& c = picture.pixels[200 * y + x];
      const bool inside = std::hypot(static_cast<double>(x) + 0.5 - 100, static_cast<double>(y) + 0.5 - 50) < 47;
      if (c[1] != 0) continue;
      ++red;
      EXPECT_TRUE(inside);
    }
  EXPECT_NEAR(static_cast<double>(red), 3.14159 * 47 * 47, 0.01 * 3.14159 * 47 * 47);
}

TEST(Picture, TheNearerFaceIsSeen) {
  Mesh two = square(0);
  const Mesh front = square(1);
  two.positions.insert(two.positions.end(), front.positions.begin(), front.positions.end());
  two.faces.add(std::array<Index, 4>{4, 5, 6, 7});
  two.colors.assign(8, Color{0, 0, 255});
  std::fill(two.colors.begin() + 4, two.colors.end(), Color{255, 0, 0});
  const auto middle = [&](const Vec3& from) { return draw(two, {from, Vec3::UnitY()}, 51, 51).pixels[51 * 25 + 25]; };
  EXPECT_GT(middle(Vec3::UnitZ())[0], 200);
  EXPECT_GT(middle(-Vec3::UnitZ())[2], 200);
}

TEST(Picture, BitmapHasItsHeaderAndPaddedRows) {
  const Picture picture{3, 2, std::vector<Color>(6, Color{1, 2, 3})};
  const std::string bytes = to_bitmap(picture);
  ASSERT_EQ(bytes.size(), 54U + 2 * 12);
  EXPECT_EQ(bytes.substr(0, 2), "BM");
  EXPECT_EQ(bytes[2], static_cast<char>(bytes.size()));
  EXPECT_EQ(bytes.substr(54, 3), std::string("\3\2\1"));  // blue first
}

class Page : public testing::Test {
 protected:
  Page() {
    Mesh bumpy = sphere(3);
    Random random(73);
    for (Vec3& p : bumpy.positions) p *= random.uniform(0.95, 1.05);
    mesh_ = bumpy;
    CompareOptions options;
    options.samples = 2000;
    report_ = report_of(compare(mesh_, sphere(4), options));
    map_ = error_map(mesh_, sphere(4));
    options_.title = "a <b> & \"c\"";
  }
  std::string page() const { return html_report(report_, mesh_, map_, options_); }

  Mesh mesh_;
  ErrorReport report_;
  ErrorMap map_;
  HtmlOptions options_;
};

/// The text of the element that holds the mesh.
nlohmann::json data_of(const std::string& page) {
  const std::string start = "id=\"mesh-data\">";
  const std::size_t from = page.find(start) + start.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST_F(Page, HoldsTheNumbersAndNoMarks) {
  report_.warnings.push_back("beware of <script>alert(1)</script>");
  report_.options["file"] = std::string("<img src=x>");
  const std::string html = page();
  char rms[32];
  std::snprintf(rms, sizeof rms, "%.4g&nbsp;%%",
                100 * report_.reference->mesh_to_reference.distance.distance.rms / report_.diagonal);
  EXPECT_THAT(html, HasSubstr(rms));
  for (const char* mark : {"@TITLE@", "@BODY@", "@DATA@", "@VIEWER@"}) EXPECT_THAT(html, Not(HasSubstr(mark)));
  for (const char* part : {"id=\"distances\"", "id=\"coverage\"", "id=\"topology\"", "Histogram of the distances",
                           "result to reference", "reference to result", "F-score"})
    EXPECT_THAT(html, HasSubstr(part));
  EXPECT_THAT(html, HasSubstr("a &lt;b&gt; &amp; &quot;c&quot;"));
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("<img src=x>")));
}

TEST_F(Page, NeedsNothingFromElsewhere) {
  const std::string html = page();
  for (const char* fetch : {"src=\"http", "href=", "@import", "url("})
    EXPECT_THAT(html.substr(0, html.find("<script>")), Not(HasSubstr(fetch)));
}

TEST_F(Page, TheMeshIsInItWhole) {
  const nlohmann::json data = data_of(page());
  const auto bytes = [&](const char* key) { return data.at(key).get<std::string>().size() / 4 * 3; };
  EXPECT_NEAR(static_cast<double>(bytes("faces")), 12.0 * static_cast<double>(mesh_.faces.size()), 2);
  EXPECT_NEAR(static_cast<double>(bytes("positions")), 6.0 * static_cast<double>(mesh_.positions.size()), 2);
  EXPECT_NEAR(static_cast<double>(bytes("errors")), static_cast<double>(mesh_.positions.size()), 2);
  EXPECT_EQ(data.at("palette").size(), 256U);
  EXPECT_THAT(page(), Not(HasSubstr("id=\"thinned\"")));
}

TEST_F(Page, LargeMeshesAreThinnedAndThePageSaysSo) {
  options_.max_faces = 200;
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("id=\"thinned\""));
  const std::size_t faces = data_of(html).at("faces").get<std::string>().size() / 4 * 3 / 12;
  EXPECT_LE(faces, 200U);
  EXPECT_GE(faces, 50U);
}

TEST_F(Page, TheSameEveryTime) {
  EXPECT_EQ(page(), page());
}

TEST_F(Page, TooFewFacesAreRefused) {
  options_.max_faces = 99;
  EXPECT_THROW(page(), OptionError);
}

}  // namespace
}  // namespace gpsrecon::test
