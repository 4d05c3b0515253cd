#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/local_scale.h>
#include <gpsrecon/core/order_statistics.h>
#include <tuple>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;
using testing::Each;
using testing::Ge;
using testing::Le;

/// In an order close in space, as prepared clouds are: by strips.
std::vector<Vec3> in_strips(std::vector<Vec3> points, double width) {
  const auto key = [width](const Vec3& p) {
    return std::tuple(std::floor(p.z() / width), std::floor(p.x() / width), p.y(), p.x(), p.z());
  };
  std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) { return key(a) < key(b); });
  return points;
}

LocalScale local_scale(const std::vector<Vec3>& points, const std::vector<Vec3>& sensors = {}, int threads = 0) {
  const Neighbors index(points);
  std::vector<double> by_neighbors;
  std::vector<Neighbor> near;
  for (const Vec3& p : points) {
    index.nearest(p, 9, near);
    by_neighbors.push_back(near.back().distance * std::sqrt(std::numbers::pi / static_cast<double>(near.size())));
  }
  RunContext context;
  context.threads = threads;
  return estimate_local_scale(points, sensors, index, by_neighbors, context);
}

double median_of(std::vector<double> values) {
  return median(values);
}

/// The quadric takes the curvature away: a tenth of the thickness of a cap of 24 points is a generous bound of the
/// rest.
TEST(LocalScale, CurvatureIsNoNoise) {
  for (const std::size_t n : {1000U, 10000U}) {
    const test::SampledShape sphere = test::random_sphere(n, 1);
    const double cap = 24 * sphere.spacing() * sphere.spacing() / (2 * std::numbers::pi * std::sqrt(12));
    EXPECT_LT(median_of(local_scale(in_strips(sphere.points, 0.1)).noise), 0.1 * cap) << n;
  }
}

/// Residuals of k points about a surface of six terms, or more points where the sheet is thicker than a ball of so few.
TEST(LocalScale, NoiseOfASheetSmallerAndLargerThanTheSpacing) {
  for (const double share : {0.05, 0.3, 1.0, 3.0}) {
    test::SampledShape plane = test::rectangle(40000, 10, 10, 2);
    const double sigma = share * plane.spacing();
    add_noise(plane, sigma, 3);
    EXPECT_NEAR(median_of(local_scale(in_strips(plane.points, 0.5)).noise) / sigma, 1, 0.15) << share;
  }
}

/// Depth cameras: the noise grows with the distance.
TEST(LocalScale, NoiseThatDiffersFromPlaceToPlace) {
  test::SampledShape plane = test::rectangle(40000, 20, 5, 4);
  Random random(5);
  const auto sigma = [&](const Vec3& p) { return 0.05 * plane.spacing() * std::pow(20, (p.x() + 10) / 20); };
  for (Vec3& p : plane.points) p.z() = sigma(p) * random.normal();
  const std::vector<Vec3> points = in_strips(plane.points, 0.5);
  const LocalScale scale = local_scale(points);
  std::vector<double> ratio;
  for (std::size_t i = 0; i < points.size(); ++i) ratio.push_back(scale.noise[i] / sigma(points[i]));
  std::sort(ratio.begin(), ratio.end());
  EXPECT_GT(ratio[ratio.size() / 20], 0.7);
  EXPECT_LT(ratio[ratio.size() - ratio.size() / 20], 1.35);
}

/// A sensor that stands still: the same directions in every frame. Without more than neighbours, 15 points close
/// together make the spacing about nothing.
TEST(LocalScale, SpacingOfRepeatedPointsIsThatOfTheDirections) {
  for (const double jitter : {1e-6, 0.004}) {
    const test::SampledShape sphere = test::random_sphere(2000, 6);
    Random random(7);
    std::vector<Vec3> points;
    for (const Vec3& p : sphere.points)
      for (int frame = 0; frame < 15; ++frame) points.push_back((1 + jitter * random.normal()) * p);
    const double ratio = median_of(local_scale(in_strips(points, 0.1)).spacing) / sphere.spacing();
    EXPECT_GT(ratio, 0.4) << jitter;
    EXPECT_LT(ratio, 1.6) << jitter;
  }
}

TEST(LocalScale, SpacingOfScanLinesIsThatBetweenThem) {
  for (const int ratio : {10, 25}) {
    const double gap = 0.5, along = gap / ratio;
    Random random(8);
    std::vector<Vec3> points;
    for (int line = 0; line < 30; ++line)
      for (int k = 0; k < 30 * ratio; ++k)
        points.emplace_back(gap * line, along * (k + random.uniform()), 0.01 * random.normal());
    const double spacing = median_of(local_scale(points).spacing);
    // A place is at most half the gap from a line: as from points spread evenly with half its spacing.
    EXPECT_GT(spacing, 0.4 * gap) << ratio;
    EXPECT_LT(spacing, 0.8 * gap) << ratio;
  }
}

TEST(LocalScale, SpacingWhereDensitiesDiffer) {
  const test::SampledShape fine = test::rectangle(20000, 1, 1, 9);
  std::vector<Vec3> points = in_strips(fine.points, 0.05);
  const std::size_t fine_count = points.size();
  test::SampledShape coarse = test::rectangle(20000, 1000, 1000, 10);
  for (const Vec3& p : in_strips(coarse.points, 50)) points.push_back(p);
  const LocalScale scale = local_scale(points);
  const auto share_near = [&](std::size_t begin, std::size_t end, double spacing) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i)
      count += scale.spacing[i] > 0.6 * spacing && scale.spacing[i] < 1.6 * spacing ? 1 : 0;
    return static_cast<double>(count) / static_cast<double>(end - begin);
  };
  EXPECT_GT(share_near(0, fine_count, fine.spacing()), 0.97);
  EXPECT_GT(share_near(fine_count, points.size(), coarse.spacing()), 0.97);
}

/// Depths that a sensor rounds lie in layers, each without noise. Behind each other as seen from the sensor, they are
/// one surface; to either side of a wall, two.
TEST(LocalScale, LayersAreNoiseAndWallsAreNot) {
  const double spacing = 0.05, step = 0.3;
  Random random(11);
  std::vector<Vec3> points;
  for (int x = 0; x < 150; ++x)
    for (int y = 0; y < 150; ++y) {
      const double depth = 3 + 0.1 * spacing * x;
      points.emplace_back(spacing * (x + random.uniform(0, 0.3)), spacing * (y + random.uniform(0, 0.3)),
                          -step * std::round((depth + 0.6 * step * random.normal()) / step));
    }
  const std::vector<Vec3> sensors(points.size(), Vec3(3, 3, 100));
  const double noise = step * std::hypot(0.6, 1 / std::sqrt(12.0));
  EXPECT_NEAR(median_of(local_scale(points, sensors).noise) / noise, 1, 0.3);
  // Without sensors layers without any thickness are still none.
  EXPECT_GT(median_of(local_scale(points).noise) / noise, 0.3);

  std::vector<Vec3> wall, around;
  for (const double side : {-1.0, 1.0})
    for (int x = 0; x < 100; ++x)
      for (int y = 0; y < 100; ++y) {
        wall.emplace_back(spacing * (x + random.uniform(0, 0.3)), spacing * (y + random.uniform(0, 0.3)),
                          side * spacing + 0.1 * spacing * random.normal());
        around.emplace_back(3, 3, side * 100);
      }
  EXPECT_NEAR(median_of(local_scale(wall, around).noise) / (0.1 * spacing), 1, 0.15);
}

TEST(LocalScale, FollowsTheUnits) {
  test::SampledShape shape = test::random_sphere(5000, 12);
  add_noise(shape, 0.01, 13);
  std::vector<Vec3> points = in_strips(shape.points, 0.1);
  const LocalScale reference = local_scale(points);
  for (Vec3& p : points) p *= 1024;
  const LocalScale scaled = local_scale(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(scaled.spacing[i] / 1024, reference.spacing[i], 1e-12);
    EXPECT_NEAR(scaled.noise[i] / 1024, reference.noise[i], 1e-12);
  }
}

TEST(LocalScale, SameForAnyNumberOfThreads) {
  test::SampledShape shape = test::random_sphere(20000, 14);
  add_noise(shape, 0.01, 15);
  const LocalScale one = local_scale(shape.points, {}, 1);
  for (const int threads : {2, 7}) {
    const LocalScale more = local_scale(shape.points, {}, threads);
    EXPECT_EQ(more.spacing, one.spacing);
    EXPECT_EQ(more.noise, one.noise);
  }
}

TEST(LocalScale, OfFewAndDegeneratePoints) {
  for (const std::vector<Vec3>& points :
       {std::vector<Vec3>{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, std::vector<Vec3>(40, Vec3(1, 2, 3)),
        std::vector<Vec3>{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0), Vec3(5, 0, 0)}}) {
    const LocalScale scale = local_scale(points);
    EXPECT_THAT(scale.spacing, Each(testing::AllOf(Ge(0.0), Le(20.0))));
    EXPECT_THAT(scale.noise, Each(testing::AllOf(Ge(0.0), Le(5.0))));
  }
}

}  // namespace
}  // namespace gpsrecon
