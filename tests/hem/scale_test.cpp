#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/scale.h>

#include "support/shapes.h"

namespace gpsrecon {
namespace {

using test::Random;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// The median of the Gamma distribution of order 8: of λπr² for the distance r to the 8th neighbour in a random
/// sampling of λ points per area, where 9 points in the disc are counted.
constexpr double median_gamma_8 = 7.66925;

TEST(Scale, SpacingOfRandomSamplingIsEightPercentLow) {
  for (const double radius : {1.0, 250.0}) {
    const test::SampledShape sphere = test::random_sphere(40000, 21, radius);
    const Scale scale = estimate_scale(sphere.cloud());
    // The distance has a relative deviation of 1/(2√8); its median over N/9 independent ones is good to 0.35 %.
    EXPECT_NEAR(scale.spacing / sphere.spacing(), std::sqrt(median_gamma_8 / 9), 0.012);
    // There is no noise: the cap of 48 points is as thick as its heights, uniform in [0, r²/2R], deviate, but curvature
    // is no noise.
    const double cap = 48 / std::numbers::pi * sphere.spacing() * sphere.spacing() / (2 * radius);
    EXPECT_LT(scale.noise, 0.1 * cap / std::sqrt(12));
    EXPECT_NEAR(scale.sigma0, std::hypot(scale.spacing, scale.noise), 1e-12 * radius);
  }
}

TEST(Scale, SpacingOfASquareGridIsExact) {
  PointCloud cloud;
  for (int x = 0; x < 60; ++x)
    for (int y = 0; y < 60; ++y) cloud.positions.emplace_back(0.25 * x, 0.25 * y, 0);
  // The 8th neighbour of all but the rim is the diagonal one.
  EXPECT_NEAR(estimate_scale(cloud).spacing, 0.25 * std::sqrt(2 * std::numbers::pi / 9), 1e-14);
}

TEST(Scale, NoiseOfAThickPlane) {
  for (const double share : {0.1, 0.3}) {
    test::SampledShape plane = test::rectangle(20000, 10, 10, 22);
    const double sigma = share * plane.spacing();
    add_noise(plane, sigma, 23);
    // A plane fitted to 48 points takes three degrees of freedom; the median of χ² with 45 is about 45 - 2/3.
    const double expected = sigma * std::sqrt((45 - 2.0 / 3) / 48);
    EXPECT_NEAR(estimate_scale(plane.cloud()).noise, expected, 0.03 * expected) << share;
  }
}

/// Two parallel sheets `gap` spacings apart, the second over `share` of the first, both with noise.
PointCloud wall(double gap, double share, double noise) {
  test::SampledShape front = test::rectangle(20000, 10, 10, 24);
  const double spacing = front.spacing();
  add_noise(front, noise * spacing, 25);
  PointCloud cloud = front.cloud();
  test::SampledShape back = test::rectangle(static_cast<std::size_t>(20000 * share), 10 * share, 10, 26);
  add_noise(back, noise * spacing, 27);
  for (const Vec3& p : back.points) cloud.positions.push_back(p + gap * spacing * Vec3::UnitZ());
  return cloud;
}

TEST(Scale, ThicknessOfAWallIsNoNoise) {
  for (const double gap : {1.5, 2.0, 2.5}) {
    const double noise = 0.2, spacing = 10 / std::sqrt(20000.0);
    // The ball of 48 points cuts a disc of radius r out of one sheet and of √(r² - gap²) out of the other.
    const double own = 0.5 * (48 + std::numbers::pi * gap * gap);
    const double expected = noise * spacing * std::sqrt((own - 3 - 2.0 / 3) / own);
    const Scale scale = estimate_scale(wall(gap, 1, noise));
    EXPECT_TRUE(scale.thin_walls);
    EXPECT_NEAR(scale.noise, expected, 0.04 * expected) << gap;
  }
}

/// So that one surface that shows as two here and there keeps its thickness: the median is that of all places.
TEST(Scale, AFewPlacesWithTwoSheetsMoveTheMedianOnly) {
  const double noise = 0.2, spacing = 10 / std::sqrt(20000.0), share = 0.1;
  // The share of the points in the doubled part, where all thicknesses are above the median; it is a higher quantile of
  // the others.
  const double doubled = 2 * share / (1 + share), rank = 0.5 / (1 - doubled);
  const double normal_quantile = std::sqrt(2 * std::numbers::pi) * (rank - 0.5);  // to first order
  const double expected = noise * spacing * (std::sqrt((45 - 2.0 / 3) / 48) + normal_quantile / std::sqrt(2.0 * 48));
  const Scale scale = estimate_scale(wall(3, share, noise));
  EXPECT_FALSE(scale.thin_walls);
  EXPECT_NEAR(scale.noise, expected, 0.01 * expected);
}

TEST(Scale, LengthsFollowTheUnits) {
  test::SampledShape shape = test::random_sphere(3000, 24);
  add_noise(shape, 0.01, 25);
  shape.points.push_back(Vec3(9, 9, 9));
  const Scale reference = estimate_scale(shape.cloud());
  for (const double factor : {1000.0, 0.3, std::ldexp(1.0, -9)}) {
    PointCloud cloud = shape.cloud();
    for (Vec3& p : cloud.positions) p *= factor;
    const Scale scale = estimate_scale(cloud);
    EXPECT_NEAR(scale.spacing / factor, reference.spacing, 1e-12);
    EXPECT_NEAR(scale.noise / factor, reference.noise, 1e-12);
    EXPECT_EQ(scale.isolated, reference.isolated);
  }
}

TEST(Scale, IsolatedPointsAreFoundExactly) {
  PointCloud cloud = test::fibonacci_sphere(2000).cloud();
  std::vector<Index> planted;
  Random random(26);
  for (const Index at : {3U, 400U, 401U, 1999U, 2004U}) {
    cloud.positions.insert(cloud.positions.begin() + at, (2 + random.uniform()) * random.direction());
    planted.push_back(at);
  }
  EXPECT_EQ(estimate_scale(cloud).isolated, planted);
  EXPECT_THAT(estimate_scale(cloud, {.isolation = 0}).isolated, testing::IsEmpty());
  // From the planted points the 8th neighbour is at least at distance 1, everywhere else within a few spacings.
  EXPECT_EQ(estimate_scale(cloud, {.isolation = 6}).isolated, planted);
}

TEST(Scale, FewPoints) {
  for (std::size_t n = 0; n < 3; ++n) {
    PointCloud cloud;
    for (std::size_t i = 0; i < n; ++i) cloud.positions.emplace_back(static_cast<double>(i), 0, 0);
    EXPECT_THAT([&] { estimate_scale(cloud); },
                ThrowsMessage<NoSurfaceError>(HasSubstr(std::to_string(n) + " distinct point")));
  }
  PointCloud three;
  three.positions = {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 4, 0)};
  const Scale scale = estimate_scale(three);
  // Farthest of the others: 4, 5, 5. A disc of that radius holds all three.
  EXPECT_NEAR(scale.spacing, 5 * std::sqrt(std::numbers::pi / 3), 1e-14);
  EXPECT_NEAR(scale.noise, 0, 1e-7);
}

TEST(Scale, PointsOnALineHaveNoThickness) {
  PointCloud cloud;
  for (int i = 0; i < 100; ++i) cloud.positions.push_back(0.1 * i * Vec3(1, 2, -2));
  const Scale scale = estimate_scale(cloud);
  EXPECT_NEAR(scale.spacing, 4 * 0.3 * std::sqrt(std::numbers::pi / 9), 1e-12);
  EXPECT_NEAR(scale.noise, 0, 1e-7);
}

TEST(Scale, SameForAnyNumberOfThreads) {
  test::SampledShape shape = test::random_sphere(30000, 27);
  add_noise(shape, 0.01, 28);
  RunContext context;
  context.threads = 1;
  const Scale reference = estimate_scale(shape.cloud(), {}, context);
  for (const int threads : {2, 4, 8}) {
    context.threads = threads;
    const Scale scale = estimate_scale(shape.cloud(), {}, context);
    EXPECT_EQ(scale.spacing, reference.spacing);
    EXPECT_EQ(scale.noise, reference.noise);
    EXPECT_EQ(scale.isolated, reference.isolated);
  }
}

TEST(Scale, OptionsOutOfRangeNameTheField) {
  for (const double isolation : {1.0, 0.5, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT([&] { estimate_scale(test::fibonacci_sphere(20).cloud(), {.isolation = isolation}); },
                ThrowsMessage<OptionError>(HasSubstr("isolation")));
}

}  // namespace
}  // namespace gpsrecon
