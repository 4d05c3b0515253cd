// Colours, quantities and labels of points in the mixture.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/hem/attributes.h>
#include <gpsrecon/hem/hem.h>
#include <cstring>
#include <limits>
#include <set>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;
using testing::ElementsAre;
using testing::IsNan;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double largest_float = std::numeric_limits<float>::max();

TEST(CarryAttributes, MeansByWeightAndMajorityOfWeight) {
  PointCloud cloud;
  cloud.positions.assign(7, Vec3::Zero());
  cloud.weights = {1, 3, 2, 1, 1, 1, 1};
  cloud.colors = {{0, 10, 255}, {8, 20, 255}, {1, 2, 3}, {4, 2, 3}, {0, 0, 0}, {0, 0, 1}, {0, 0, 0}};
  cloud.scalars = {{"intensity", {1, 5, nan, 7, nan, -std::numeric_limits<double>::infinity(), largest_float}},
                   {"class", {2, 5, 9, nan, 4, 3, 3}, ScalarKind::label}};
  Mixture mixture;
  mixture.means.assign(3, Vec3::Zero());
  carry_attributes(cloud, std::vector<Index>{0, 0, 1, 1, 2, 2, 2}, mixture, {});
  // (0 + 3*8)/4, (10 + 3*20)/4 = 17.5; (2*1 + 4)/3; a third of one is none.
  EXPECT_THAT(mixture.colors, ElementsAre(Color{6, 18, 255}, Color{2, 2, 3}, Color{0, 0, 0}));
  ASSERT_EQ(mixture.scalars.size(), 2u);
  EXPECT_THAT(mixture.scalars[0].values, ElementsAre(4, 7, IsNan()));
  EXPECT_THAT(mixture.scalars[1].values, ElementsAre(5, 9, 3));
  EXPECT_EQ(mixture.scalars[0].kind, ScalarKind::quantity);
  EXPECT_EQ(mixture.scalars[1].kind, ScalarKind::label);
}

TEST(CarryAttributes, TheSmallestOfLabelsWithEqualWeightAndNaNWhereThereIsNone) {
  PointCloud cloud;
  cloud.positions.assign(5, Vec3::Zero());
  cloud.scalars = {{"label", {7, -2, 7, -2, nan}, ScalarKind::label}};
  Mixture mixture;
  mixture.means.assign(2, Vec3::Zero());
  carry_attributes(cloud, std::vector<Index>{0, 0, 0, 0, 1}, mixture, {});
  EXPECT_THAT(mixture.scalars[0].values, ElementsAre(-2, IsNan()));
}

/// A square of points with a colour and a quantity that grow along x, and a label for each half.
PointCloud striped_square(std::size_t n) {
  Random random(5);
  PointCloud cloud;
  cloud.scalars = {{"ramp", {}}, {"half", {}, ScalarKind::label}};
  for (std::size_t i = 0; i < n; ++i) {
    const double x = random.uniform(), y = random.uniform();
    cloud.positions.emplace_back(x, y, 0.0005 * random.normal());
    cloud.colors.push_back({static_cast<std::uint8_t>(std::lround(255 * x)), 77, 255});
    cloud.scalars[0].values.push_back(x);
    cloud.scalars[1].values.push_back(x < 0.5 ? 3 : 40);
  }
  return cloud;
}

TEST(Hem, CarriesAttributes) {
  const PointCloud cloud = striped_square(20000);
  const double spacing = 1 / std::sqrt(20000.0);
  const Mixture mixture = build_mixture(cloud);
  validate(mixture);
  ASSERT_EQ(mixture.colors.size(), mixture.size());
  ASSERT_EQ(mixture.scalars.size(), 2u);
  EXPECT_LT(mixture.size(), cloud.size() / 5);
  double square = 0;
  for (std::size_t s = 0; s < mixture.size(); ++s) {
    const double x = mixture.means[s].x();
    const double error = mixture.scalars[0].values[s] - x;
    square += error * error;
    // Points belong to one component each, but gave all around them a share: their centroid is not quite the mean.
    EXPECT_LT(std::abs(error), 2 * spacing);
    EXPECT_NEAR(mixture.colors[s][0], 255 * mixture.scalars[0].values[s], 1);
    EXPECT_EQ(mixture.colors[s][1], 77);
    EXPECT_EQ(mixture.colors[s][2], 255);
    EXPECT_THAT(mixture.scalars[1].values[s], testing::AnyOf(3, 40));
    if (std::abs(x - 0.5) > 3 * spacing) {
      EXPECT_EQ(mixture.scalars[1].values[s], x < 0.5 ? 3 : 40) << x;
    }
  }
  EXPECT_LT(std::sqrt(square / static_cast<double>(mixture.size())), 0.6 * spacing);
}

TEST(Hem, AttributesDoNotInfluenceTheClusteringAndDependOnNoThreads) {
  const PointCloud cloud = striped_square(5000);
  PointCloud bare;
  bare.positions = cloud.positions;
  const Mixture plain = build_mixture(bare);
  EXPECT_TRUE(plain.colors.empty());
  EXPECT_TRUE(plain.scalars.empty());
  for (const int threads : {1, 3}) {
    RunContext context;
    context.threads = threads;
    const Mixture mixture = build_mixture(cloud, {}, context);
    EXPECT_EQ(mixture.means, plain.means);
    EXPECT_EQ(mixture.colors, build_mixture(cloud).colors);
    EXPECT_EQ(mixture.scalars[0].values, build_mixture(cloud).scalars[0].values);
  }
}

TEST(Columns, MarkLabelsAndMissingNumbers) {
  std::vector<ScalarColumn> columns{{"Zone", {1, nan, 3}}, {"height", {0.5, -9999, -9999.9f}}};
  mark_labels(columns, {"zone"});
  EXPECT_EQ(columns[0].kind, ScalarKind::label);
  EXPECT_EQ(columns[1].kind, ScalarKind::quantity);
  EXPECT_THROW(mark_labels(columns, {"height"}), OptionError);
  EXPECT_THROW(mark_labels(columns, {"absent"}), OptionError);
  mark_missing(columns, -9999.9);
  EXPECT_THAT(columns[1].values, ElementsAre(0.5, -9999, IsNan()));
  for (const double value : {nan, -largest_float * 1.0, 1e300}) EXPECT_TRUE(is_missing(value));
  for (const double value : {0.0, -9999.0, 1e38}) EXPECT_FALSE(is_missing(value));
}

TEST(Mixtures, KeepAttributesWhenSelectedAndCopied) {
  const PointCloud cloud = striped_square(500);
  Mixture mixture = build_mixture(cloud);
  const Mixture kept = select(mixture, {3, 1});
  EXPECT_THAT(kept.colors, ElementsAre(mixture.colors[3], mixture.colors[1]));
  EXPECT_THAT(kept.scalars[1].values, ElementsAre(mixture.scalars[1].values[3], mixture.scalars[1].values[1]));
  EXPECT_EQ(kept.scalars[1].kind, ScalarKind::label);
  const std::size_t n = mixture.size();
  EXPECT_EQ(append_copy(mixture, 2), n);
  validate(mixture);
  EXPECT_EQ(mixture.means[n], mixture.means[2]);
  EXPECT_EQ(mixture.colors[n], mixture.colors[2]);
  EXPECT_EQ(mixture.scalars[0].values[n], mixture.scalars[0].values[2]);
  mixture.colors.pop_back();
  EXPECT_THROW(validate(mixture), InvariantError);
}

}  // namespace
}  // namespace gpsrecon
