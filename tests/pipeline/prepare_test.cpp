#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::cloud_of;
using test::noisy_sphere;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Every point is the one its source index names, in the frame of the cloud.
void expect_sources_right(const PreparedCloud& prepared, const PointCloud& world) {
  const PointCloud& cloud = prepared.cloud;
  ASSERT_EQ(prepared.source.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    EXPECT_EQ(cloud.positions[i], cloud.frame.to_local(world.positions[prepared.source[i]])) << i;
}

TEST(Prepare, KeepsEveryPointOfASurface) {
  const PointCloud world = noisy_sphere(2000, 0.01);
  const PreparedCloud prepared = prepare(world);
  EXPECT_EQ(prepared.cloud.size(), 2000u);
  EXPECT_EQ(prepared.isolated, 0u);
  EXPECT_EQ(prepared.duplicates, 0u);
  EXPECT_EQ(prepared.non_finite, 0u);
  EXPECT_EQ(std::set<Index>(prepared.source.begin(), prepared.source.end()).size(), 2000u);
  EXPECT_EQ(prepared.diagonal, bounding_box_diagonal(prepared.cloud.positions));
  expect_sources_right(prepared, world);
}

TEST(Prepare, DropsAndCountsIsolatedPoints) {
  PointCloud world = noisy_sphere(2000, 0.01);
  const std::set<Index> far{7, 500, 1999};
  for (const Index i : far) world.positions[i] *= 4 + i % 3;
  const PreparedCloud prepared = prepare(world);
  EXPECT_EQ(prepared.isolated, far.size());
  EXPECT_EQ(prepared.scale.isolated.size(), far.size());
  EXPECT_EQ(prepared.cloud.size(), 2000 - far.size());
  for (const Index source : prepared.source) EXPECT_FALSE(far.contains(source));
  expect_sources_right(prepared, world);
  // The diagonal is that of the sphere, the far points are gone from it.
  EXPECT_LT(prepared.diagonal * prepared.cloud.frame.scale(), 2.2 * std::sqrt(3.0));

  EXPECT_EQ(prepare(world, {.isolation = 0}).cloud.size(), 2000u);
}

TEST(Prepare, CarriesAttributesWithThePointsItKeeps) {
  PointCloud world = noisy_sphere(1000, 0.01);
  world.positions[3] *= 5;
  world.scalars.push_back({"row", {}});
  for (std::size_t i = 0; i < world.size(); ++i) world.scalars[0].values.push_back(static_cast<double>(i));
  const PreparedCloud prepared = prepare(world);
  ASSERT_EQ(prepared.cloud.scalars.size(), 1u);
  for (std::size_t i = 0; i < prepared.cloud.size(); ++i)
    EXPECT_EQ(prepared.cloud.scalars[0].values[i], prepared.source[i]);
}

TEST(Prepare, CountsEveryRowOnce) {
  PointCloud world = noisy_sphere(1000, 0.01);
  world.positions[3] *= 5;
  for (int i = 100; i < 130; ++i) world.positions.push_back(world.positions[i]);
  for (int axis = 0; axis < 3; ++axis) {
    world.positions.push_back(Vec3::Zero());
    world.positions.back()[axis] = axis == 1 ? std::numeric_limits<double>::infinity() : nan;
  }
  const PreparedCloud prepared = prepare(world);
  EXPECT_EQ(prepared.duplicates, 30u);
  EXPECT_EQ(prepared.non_finite, 3u);
  EXPECT_EQ(prepared.isolated, 1u);
  EXPECT_EQ(prepared.cloud.size() + 34, world.size());
  double weight = 0;
  for (std::size_t i = 0; i < prepared.cloud.size(); ++i) weight += prepared.cloud.weight(i);
  EXPECT_EQ(weight, 1029);
  expect_sources_right(prepared, world);
}

TEST(Prepare, OnlyCountsACloudGivenTwice) {
  const PointCloud once = noisy_sphere(1000, 0.01);
  PointCloud twice = once;
  twice.positions.insert(twice.positions.end(), once.positions.begin(), once.positions.end());
  const PreparedCloud a = prepare(once), b = prepare(twice);
  EXPECT_EQ(a.cloud.positions, b.cloud.positions);
  EXPECT_EQ(a.cloud.frame, b.cloud.frame);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.scale.sigma0_local, b.scale.sigma0_local);
  EXPECT_EQ(b.cloud.weights, std::vector<double>(1000, 2));
}

// Offset and points are multiples of the same power of two, so nothing is rounded and the local bits are the same.
TEST(Prepare, DoesNotSeeAFarOrigin) {
  const PointCloud near = test::on_grid(noisy_sphere(2000, 0.01));
  const Vec3 utm(500'000, 5'400'000, 300);
  const PreparedCloud a = prepare(near), b = prepare(test::shifted(near, utm));
  EXPECT_EQ(a.cloud.positions, b.cloud.positions);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.scale.spacing, b.scale.spacing);
  EXPECT_EQ(a.scale.noise, b.scale.noise);
  EXPECT_EQ(Vec3(b.cloud.frame.origin - a.cloud.frame.origin), utm);
}

TEST(Prepare, RefusesWhatHasNoSurface) {
  const Vec3 p(1, 2, 3), step = Vec3(3, -1, 2).normalized();
  EXPECT_THROW(prepare(cloud_of({p})), NoSurfaceError);
  EXPECT_THROW(prepare(cloud_of({p, p + step})), NoSurfaceError);
  EXPECT_THROW(prepare(cloud_of(std::vector<Vec3>(100, p))), NoSurfaceError);
  EXPECT_THROW(prepare(cloud_of({p, p, p + step, p + step, {nan, 0, 0}})), NoSurfaceError);
  test::Random random(2);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    PointCloud line;
    for (int i = 0; i < 300; ++i) line.positions.push_back(scale * (p + random.uniform(-5, 5) * step));
    EXPECT_THROW(prepare(line), NoSurfaceError) << scale;
  }
}

// What is left after isolated points are gone is looked at again.
TEST(Prepare, RefusesALineWithAPointFarOff) {
  PointCloud cloud;
  for (int i = 0; i < 300; ++i) cloud.positions.emplace_back(0.01 * i, 0, 0);
  cloud.positions.emplace_back(0, 50, 0);
  EXPECT_THROW(prepare(cloud), NoSurfaceError);
}

TEST(Prepare, RefusesCloudsWithoutFinitePoint) {
  EXPECT_THROW(prepare({}), InputError);
  EXPECT_THROW(prepare(cloud_of({{nan, 0, 0}, {0, -std::numeric_limits<double>::infinity(), 0}})), InputError);
}

TEST(Prepare, AcceptsThreePoints) {
  EXPECT_EQ(prepare(cloud_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})).cloud.size(), 3u);
}

}  // namespace
}  // namespace gpsrecon
