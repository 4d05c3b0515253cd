#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/clean.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/in_frame.h>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>

#include "support/same_bytes.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::cloud_of;
using test::Random;
using test::same_bytes;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Diagonal of the box of the 1 % and 99 % quantiles, by sorting.
double robust_diagonal(const std::vector<Vec3>& points) {
  Vec3 extent;
  const std::size_t low = points.size() / 100;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vec3& p : points) values.push_back(p[axis]);
    std::sort(values.begin(), values.end());
    extent[axis] = values[values.size() - 1 - low] - values[low];
  }
  return extent.norm();
}

TEST(Clean, LocalRobustDiagonalIsInOneTwo) {
  for (const double size : {1e-9, 3e-4, 0.7, 1.0, 1.9999, 2.0, 1234.5, 7e11}) {
    const CleanCloud c = clean(test::random_sphere(1000, 5, size).cloud());
    const double diagonal = robust_diagonal(c.cloud.positions);
    EXPECT_GE(diagonal, 1 - 1e-12) << size;
    EXPECT_LT(diagonal, 2 + 1e-12) << size;
    // Centred to the grid of the origin, 2^-8 of the unit, and the rounding of quantiles.
    EXPECT_LT(bounding_box_diagonal(c.cloud.positions), 2.1);
    for (const Vec3& p : c.cloud.positions) EXPECT_LT(p.cwiseAbs().maxCoeff(), 1.2);
  }
}

TEST(Clean, RowsThatAreNotFiniteAreDroppedAndCounted) {
  std::vector<Vec3> points = test::fibonacci_sphere(50).points;
  points.insert(points.begin() + 7, Vec3(nan, 0, 0));
  points.insert(points.begin() + 20, Vec3(0, infinity, 0));
  points.push_back(Vec3(1, 2, -infinity));
  const CleanCloud c = clean(cloud_of(points));
  EXPECT_EQ(c.non_finite, 3U);
  EXPECT_EQ(c.duplicates, 0U);
  EXPECT_EQ(c.cloud.size(), 50U);
  EXPECT_TRUE(c.cloud.weights.empty());
  std::vector<Index> source = c.source;
  std::sort(source.begin(), source.end());
  EXPECT_EQ(std::adjacent_find(source.begin(), source.end()), source.end());
  for (std::size_t i = 0; i < c.cloud.size(); ++i) {
    EXPECT_TRUE(points[c.source[i]].allFinite());
    EXPECT_LT((c.cloud.frame.to_world(c.cloud.positions[i]) - points[c.source[i]]).norm(), 1e-15);
  }
}

TEST(Clean, NoFinitePointIsAnInputError) {
  EXPECT_THROW(clean(PointCloud{}), InputError);
  EXPECT_THROW(clean(cloud_of({Vec3(nan, nan, nan), Vec3(infinity, 0, 0)})), InputError);
}

TEST(Clean, OnePointAndEqualPointsBecomeOnePointAtTheOrigin) {
  for (const std::size_t n : {1, 2, 150}) {
    const CleanCloud c = clean(cloud_of(std::vector<Vec3>(n, Vec3(5e5, -3.25, 1e-3))));
    ASSERT_EQ(c.cloud.size(), 1U);
    EXPECT_EQ(c.duplicates, n - 1);
    EXPECT_EQ(c.cloud.weight(0), static_cast<double>(n));
    EXPECT_EQ(c.source[0], 0U);
    EXPECT_LT(c.cloud.positions[0].norm(), 1.0);
  }
}

TEST(Clean, DuplicatesMergeIntoTheFirstAndCountAsWeight) {
  Random random(3);
  PointCloud cloud;
  std::map<std::tuple<double, double, double>, std::pair<double, Index>> expected;  // weight, first index
  for (Index i = 0; i < 2000; ++i) {
    const Vec3 p(static_cast<double>(random.below(7)), static_cast<double>(random.below(7)),
                 static_cast<double>(random.below(7)));
    cloud.positions.push_back(p);
    cloud.weights.push_back(static_cast<double>(1 + random.below(3)));
    cloud.colors.push_back({static_cast<std::uint8_t>(i % 251), 0, 0});
    const auto [at, is_new] = expected.try_emplace({p.x(), p.y(), p.z()}, 0.0, i);
    at->second.first += cloud.weights.back();
  }
  const CleanCloud c = clean(cloud);
  ASSERT_EQ(c.cloud.size(), expected.size());
  EXPECT_EQ(c.duplicates, cloud.size() - expected.size());
  for (std::size_t i = 0; i < c.cloud.size(); ++i) {
    const Vec3& p = cloud.positions[c.source[i]];
    const auto& [weight, first] = expected.at({p.x(), p.y(), p.z()});
    EXPECT_EQ(c.cloud.weight(i), weight);
    EXPECT_EQ(c.source[i], first);
    EXPECT_EQ(c.cloud.colors[i], cloud.colors[first]);
    EXPECT_EQ(c.cloud.frame.to_world(c.cloud.positions[i]), p);  // small integers survive the frame exactly
  }
}

TEST(Clean, AFewFarPointsDoNotSetTheScale) {
  PointCloud cloud = test::random_sphere(1000, 8).cloud();
  const Frame without = clean(cloud).cloud.frame;
  for (int k = 0; k < 5; ++k) cloud.positions.push_back(Vec3(1e7 * (k + 1), -1e8, 1e6));
  const CleanCloud with = clean(cloud);
  EXPECT_EQ(with.cloud.frame.exponent, without.exponent);
  EXPECT_LT((with.cloud.frame.origin - without.origin).norm(), 0.05);
  EXPECT_EQ(with.cloud.size(), 1005U);
}

TEST(Clean, AFarPointDoesNotSetTheScaleOfACoordinatePlane) {
  PointCloud cloud = test::rectangle(1000, 1, 1, 4).cloud();
  const Frame without = clean(cloud).cloud.frame;
  cloud.positions.push_back(Vec3(0, 0, 1e6));
  EXPECT_EQ(clean(cloud).cloud.frame.exponent, without.exponent);
}

TEST(Clean, PointsThatMostlyCoincideStillGetAScale) {
  std::vector<Vec3> points(1000, Vec3(1, 1, 1));
  points.push_back(Vec3(1, 1, 4));
  const CleanCloud c = clean(cloud_of(points));
  ASSERT_EQ(c.cloud.size(), 2U);
  const double distance = (c.cloud.positions[0] - c.cloud.positions[1]).norm();
  EXPECT_GE(distance, 1);
  EXPECT_LT(distance, 2);
}

TEST(Clean, OrderDoesNotDependOnTheOrderOfTheInput) {
  PointCloud cloud = test::random_sphere(3000, 9).cloud();
  cloud.positions.insert(cloud.positions.end(), cloud.positions.begin(), cloud.positions.begin() + 300);
  cloud.positions.push_back(Vec3(1e5, 2e5, -3e5));
  cloud.positions.push_back(Vec3(1e5, 3e5, -3e5));  // far away, in the same outermost cell
  cloud.positions.push_back(Vec3(nan, 0, 0));
  const CleanCloud reference = clean(cloud);
  Random random(10);
  for (int trial = 0; trial < 5; ++trial) {
    random.shuffle(cloud.positions);
    const CleanCloud c = clean(cloud);
    EXPECT_TRUE(same_bytes(c.cloud.positions, reference.cloud.positions));
    EXPECT_EQ(c.cloud.weights, reference.cloud.weights);
    EXPECT_TRUE(c.cloud.frame == reference.cloud.frame);
  }
}

TEST(Clean, OrderIsCloseInSpace) {
  // Consecutive points of a space-filling order are a few spacings apart, of a random order half the diameter.
  const test::SampledShape sphere = test::random_sphere(5000, 11);
  const CleanCloud c = clean(sphere.cloud());
  double step = 0;
  for (std::size_t i = 1; i < c.cloud.size(); ++i)
    step += (c.cloud.positions[i] - c.cloud.positions[i - 1]).norm() * c.cloud.frame.scale();
  EXPECT_LT(step / 4999, 4 * sphere.spacing());
}

TEST(Clean, ScalingByPowersOfTwoChangesNoLocalByte) {
  const test::SampledShape shape = test::random_sphere(2000, 12, 1, Vec3(0.3, -7.1, 2.9));
  const CleanCloud reference = clean(shape.cloud());
  for (const int k : {-40, -3, 1, 20, 60}) {
    PointCloud scaled = shape.cloud();
    for (Vec3& p : scaled.positions) p *= std::ldexp(1.0, k);
    const CleanCloud c = clean(scaled);
    EXPECT_TRUE(same_bytes(c.cloud.positions, reference.cloud.positions)) << k;
    EXPECT_EQ(c.source, reference.source);
    EXPECT_EQ(c.cloud.frame.exponent, reference.cloud.frame.exponent + k);
    EXPECT_EQ(c.cloud.frame.origin, reference.cloud.frame.origin * std::ldexp(1.0, k));
  }
}

TEST(Clean, SameBytesForAnyNumberOfThreads) {
  const PointCloud cloud = test::random_sphere(20000, 13).cloud();
  RunContext context;
  context.threads = 1;
  const CleanCloud reference = clean(cloud, context);
  for (const int threads : {2, 4, 8}) {
    context.threads = threads;
    const CleanCloud c = clean(cloud, context);
    EXPECT_TRUE(same_bytes(c.cloud.positions, reference.cloud.positions));
    EXPECT_EQ(c.source, reference.source);
  }
}

TEST(Clean, WorldCoordinatesGiveBackTheLocalBits) {
  // What went out to world coordinates and came back once must not change any more: files hold the world's values.
  Random random(14);
  for (const double size : {1e-3, 0.37, 1.0, 80.0, 3e4})
    for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(0.123, -5.7, 1e3), Vec3(6e5 + 0.1, 5e6 + 0.7, 312.3)}) {
      const Frame frame = clean(test::random_sphere(500, 15, size, offset).cloud()).cloud.frame;
      for (int k = 0; k < 5000; ++k) {
        const double reach = std::ldexp(1.0, static_cast<int>(random.below(24)) - 20);
        const Vec3 local = random.vector(-reach, reach);
        const Vec3 once = frame.to_local(frame.to_world(local));
        const Vec3 twice = frame.to_local(frame.to_world(once));
        ASSERT_EQ(once, twice) << "size " << size << " offset " << offset.transpose();
        // Nothing is lost but the resolution of the world coordinates themselves.
        const double world = frame.to_world(local).cwiseAbs().maxCoeff() + frame.scale() * reach;
        ASSERT_LE((once - local).cwiseAbs().maxCoeff() * frame.scale(), 4e-16 * world);
      }
    }
}

TEST(Clean, AroundTheOriginNothingIsMoved) {
  // The origin of the frame lies on a coarse grid, so that a cloud centred up to sampling keeps its own, and the change
  // of frame is exact both ways.
  const test::SampledShape sphere = test::random_sphere(20000, 18);
  const CleanCloud c = clean(sphere.cloud());
  EXPECT_EQ(c.cloud.frame.origin, Vec3::Zero());
  for (std::size_t i = 0; i < c.cloud.size(); ++i)
    ASSERT_EQ(c.cloud.frame.to_world(c.cloud.positions[i]), sphere.points[c.source[i]]);
}

TEST(Clean, AttributesFollowTheirPoints) {
  PointCloud cloud = test::random_sphere(400, 16, 3).cloud();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.normals.push_back(cloud.positions[i].normalized());
    cloud.colors.push_back({static_cast<std::uint8_t>(i % 256), static_cast<std::uint8_t>(i / 256), 0});
    cloud.sensors.push_back(2 * cloud.positions[i]);
  }
  cloud.scalars.push_back({"height", {}});
  for (const Vec3& p : cloud.positions) cloud.scalars[0].values.push_back(p.z());
  const CleanCloud c = clean(cloud);
  ASSERT_NO_THROW(validate(c.cloud));
  for (std::size_t i = 0; i < c.cloud.size(); ++i) {
    const Index from = c.source[i];
    const Vec3 world = c.cloud.frame.to_world(c.cloud.positions[i]);
    EXPECT_EQ(c.cloud.normals[i], cloud.normals[from]);
    EXPECT_EQ(c.cloud.colors[i], cloud.colors[from]);
    EXPECT_EQ(c.cloud.scalars[0].values[i], cloud.positions[from].z());
    EXPECT_LT((c.cloud.frame.to_world(c.cloud.sensors[i]) - 2 * world).norm(), 1e-14);
  }
}

TEST(InFrame, KeepsTheWorldPosition) {
  const CleanCloud c = clean(test::random_sphere(100, 17, 5, Vec3(10, 20, 30)).cloud());
  const PointCloud moved = in_frame(c.cloud, Frame{Vec3(8, 16, 32), -2});
  for (std::size_t i = 0; i < c.cloud.size(); ++i)
    EXPECT_LT((moved.frame.to_world(moved.positions[i]) - c.cloud.frame.to_world(c.cloud.positions[i])).norm(), 1e-13);
  EXPECT_TRUE(same_bytes(in_frame(moved, moved.frame).positions, moved.positions));
}

}  // namespace
}  // namespace gpsrecon
