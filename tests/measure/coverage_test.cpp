#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/measure/compare.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "support/meshes.h"
#include "support/shapes.h"

// What is found, missing and spurious, which side things lie on, and clouds in either role: on shapes where all of it
// can be said exactly.

namespace gpsrecon::test {

using namespace internal;
namespace {

constexpr std::size_t n = 200000;
/// Four standard deviations of a share of a half among so many samples.
constexpr double sampling = 0.0045;

CompareOptions options(double fscore_rel = 0.0025, double far_rel = 0.01) {
  CompareOptions o;
  o.samples = n;
  o.fscore = Length::of_diagonal(fscore_rel);
  o.far = Length::of_diagonal(far_rel);
  return o;
}

/// [0, width] x [0, 1] at height z, facing up.
Mesh strip(double width, double z = 0) {
  Mesh mesh = square(z);
  mesh.positions[1].x() = mesh.positions[2].x() = width;
  return mesh;
}

TEST(Coverage, HalfASquareMissesTheOtherHalf) {
  const Mesh whole = strip(1), half = strip(0.5);
  const double d = std::sqrt(2.0);
  const ReferenceMeasures r = compare(half, whole, options()).reference.value();
  EXPECT_EQ(r.mesh_to_reference.far, 0);
  EXPECT_EQ(r.mesh_to_reference.within, 1);
  EXPECT_NEAR(r.reference_to_mesh.far, 0.5 - 0.01 * d, sampling);
  EXPECT_NEAR(r.reference_to_mesh.far_area.value(), 0.5 - 0.01 * d, sampling);
  const double recall = 0.5 + 0.0025 * d;
  EXPECT_NEAR(r.reference_to_mesh.within, recall, sampling);
  EXPECT_NEAR(r.f_score(), 2 * recall / (1 + recall), sampling);
}

TEST(Coverage, TwiceASquareIsHalfSpurious) {
  const Mesh reference = strip(1), twice = strip(2);
  const double d = std::sqrt(2.0);
  const ReferenceMeasures r = compare(twice, reference, options()).reference.value();
  EXPECT_EQ(r.reference_to_mesh.far, 0);
  EXPECT_EQ(r.reference_to_mesh.within, 1);
  EXPECT_NEAR(r.mesh_to_reference.far, (1 - 0.01 * d) / 2, sampling);
  EXPECT_NEAR(r.mesh_to_reference.far_area.value(), 1 - 0.01 * d, 2 * sampling);
  EXPECT_NEAR(r.mesh_to_reference.within, (1 + 0.0025 * d) / 2, sampling);
}

TEST(Coverage, BothThresholdsDoTheirPart) {
  const Mesh whole = strip(1), half = strip(0.5);
  const double d = std::sqrt(2.0);
  for (const double share : {0.05, 0.1, 0.2}) {
    EXPECT_NEAR(compare(half, whole, options(share)).reference->reference_to_mesh.within, 0.5 + share * d, sampling);
    EXPECT_NEAR(compare(half, whole, options(0.0025, share)).reference->reference_to_mesh.far, 0.5 - share * d,
                sampling);
  }
  EXPECT_EQ(compare(half, whole, options(0.05, 0.1)).reference->thresholds.fscore_rel, 0.05);
  EXPECT_EQ(compare(half, whole, options(0.05, 0.1)).reference->thresholds.far_rel, 0.1);
}

TEST(Coverage, UnitsAndPlaceDoNotMatter) {
  Mesh half = strip(0.5), whole = strip(1);
  const ReferenceMeasures small = compare(half, whole, options()).reference.value();
  for (Mesh* mesh : {&half, &whole})
    for (Vec3& p : mesh->positions) p = 1000 * p + Vec3(5e5, 4e6, 100);
  const ReferenceMeasures large = compare(half, whole, options()).reference.value();
  EXPECT_NEAR(large.f_score(), small.f_score(), sampling);
  EXPECT_NEAR(large.reference_to_mesh.far, small.reference_to_mesh.far, sampling);
  EXPECT_NEAR(large.reference_to_mesh.far_area.value(), 1e6 * small.reference_to_mesh.far_area.value(), 1e6 * sampling);
}

TEST(Coverage, NothingInCommonHasAnFScoreOfZero) {
  const ReferenceMeasures r = compare(square(1), square(0), options()).reference.value();
  EXPECT_EQ(r.f_score(), 0);
  EXPECT_EQ(r.mesh_to_reference.far, 1);
}

TEST(Coverage, SignTellsTheSideOfTheReference) {
  EXPECT_NEAR(compare(square(0.1), square(0), options()).reference->mesh_to_reference.signed_mean.value(), 0.1, 1e-12);
  EXPECT_NEAR(compare(square(0.1), square(0), options()).reference->reference_to_mesh.signed_mean.value(), -0.1, 1e-12);
  EXPECT_NEAR(compare(square(-0.1), square(0), options()).reference->mesh_to_reference.signed_mean.value(), -0.1,
              1e-12);
  // A sphere inside another.
  Mesh inner = sphere(4);
  for (Vec3& p : inner.positions) p *= 0.9;
  EXPECT_NEAR(compare(inner, sphere(4), options()).reference->mesh_to_reference.signed_mean.value(), -0.1, 0.002);
}

TEST(Coverage, SwappedArgumentsSwapTheDirections) {
  Mesh bumpy = sphere(3);
  Random random(71);
  for (Vec3& p : bumpy.positions) p *= random.uniform(0.9, 1.15);
  const Mesh ball = sphere(4);
  const ReferenceMeasures one = compare(bumpy, ball, options()).reference.value();
  const ReferenceMeasures other = compare(ball, bumpy, options()).reference.value();
  // Other samples, of the same distances.
  EXPECT_NEAR(one.mesh_to_reference.distance.distance.rms, other.reference_to_mesh.distance.distance.rms, 3e-4);
  EXPECT_NEAR(one.reference_to_mesh.distance.distance.rms, other.mesh_to_reference.distance.distance.rms, 3e-4);
  EXPECT_GT(std::abs(one.mesh_to_reference.distance.distance.rms - one.reference_to_mesh.distance.distance.rms),
            1.5e-3);
}

TEST(Coverage, PointsAgainstAMeshCountWithTheirWeights) {
  PointCloud cloud = cloud_of({{0.5, 0.5, 0.3}, {0.2, 0.4, -0.1}, {0.3, 0.3, 0.001}});
  cloud.weights = {1, 2, 5};
  const Comparison report = compare(cloud, square(0), options());
  const DirectionMeasures& d = report.reference.value().mesh_to_reference;
  EXPECT_FALSE(report.mesh);
  EXPECT_EQ(report.points, 3U);
  EXPECT_DOUBLE_EQ(d.distance.distance.mean, (0.3 + 2 * 0.1 + 5 * 0.001) / 8);
  EXPECT_DOUBLE_EQ(d.signed_mean.value(), (0.3 - 2 * 0.1 + 5 * 0.001) / 8);
  EXPECT_DOUBLE_EQ(d.within, 5.0 / 8);
  EXPECT_DOUBLE_EQ(d.far, 3.0 / 8);
  EXPECT_FALSE(d.far_area);
  EXPECT_EQ(d.normals.count, 0U);
  // From the square to the points: most of it is far from them.
  EXPECT_GT(report.reference->reference_to_mesh.far, 0.9);
}

TEST(Coverage, PointsAgainstPointsByBruteForce) {
  Random random(72);
  PointCloud a, b;
  for (int i = 0; i < 300; ++i) a.positions.push_back(random.vector());
  for (int i = 0; i < 400; ++i) b.positions.push_back(random.vector());
  const auto squares = [](const PointCloud& from, const PointCloud& to) {
    double sum = 0;
    for (const Vec3& p : from.positions) {
      double least = 1e300;
      for (const Vec3& q : to.positions) least = std::min(least, (p - q).squaredNorm());
      sum += least;
    }
    return sum;
  };
  const Comparison report = compare(a, b, options());
  EXPECT_NEAR(report.reference->mesh_to_reference.distance.distance.rms, std::sqrt(squares(a, b) / 300), 1e-12);
  EXPECT_NEAR(report.reference->reference_to_mesh.distance.distance.rms, std::sqrt(squares(b, a) / 400), 1e-12);
  EXPECT_DOUBLE_EQ(report.diagonal, bounding_box_diagonal(b.positions));
  EXPECT_FALSE(report.reference->mesh_to_reference.signed_mean);  // no normals, no sides
}

TEST(Coverage, NormalsOfPointsAreCompared) {
  PointCloud cloud = cloud_of({{0.5, 0.5, 0}, {0.2, 0.2, 0}});
  const double angle = 20 * std::numbers::pi / 180;
  cloud.normals = {{std::sin(angle), 0, std::cos(angle)}, {0, 0, -2}};
  const NormalMeasures normals = compare(cloud, square(0), options()).reference->mesh_to_reference.normals;
  EXPECT_EQ(normals.count, 2U);
  EXPECT_NEAR(normals.mean, 10, 1e-9);
  EXPECT_DOUBLE_EQ(normals.flipped, 0.5);
}

TEST(Coverage, SurfaceWherePointsAreNotShowsAgainstThem) {
  PointCloud cloud;
  for (int i = 0; i <= 100; ++i)
    for (int j = 0; j <= 200; ++j) cloud.positions.emplace_back(0.005 * i, 0.005 * j, 0);
  const Comparison report = compare(square(0), cloud, options(0.01, 0.01));
  ASSERT_TRUE(report.surface_to_points);
  EXPECT_LT(report.points_to_surface->distance.max, 1e-15);
  // Half of the square has no points; D is that of the cloud.
  const double far = 0.01 * std::hypot(0.5, 1.0);
  EXPECT_NEAR(report.surface_to_points->far, 0.5 - far, sampling);
  EXPECT_NEAR(report.surface_to_points->within, 0.5 + far, sampling);
}

TEST(Coverage, WhatCannotBeComparedIsRefused) {
  PointCloud bad = cloud_of({{0, 0, 0}, {0, std::numeric_limits<double>::quiet_NaN(), 0}});
  EXPECT_THROW(compare(PointCloud{}, square(0)), InvariantError);
  EXPECT_THROW(compare(bad, square(0)), InvariantError);
  EXPECT_THROW(compare(cloud_of({{0, 0, 0}}), bad), InvariantError);
  EXPECT_THROW(compare(cloud_of({{0, 0, 0}}), Mesh{}), InvariantError);
  for (const double value : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(options(value).check(), OptionError);
    EXPECT_THROW(options(0.1, value).check(), OptionError);
  }
}

}  // namespace
}  // namespace gpsrecon::test
