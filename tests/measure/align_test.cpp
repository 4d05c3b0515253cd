#include <gpsrecon/core/error.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/measure/align.h>
#include <gtest/gtest.h>

#include <numbers>

#include "support/meshes.h"
#include "support/random.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

/// A torus of unequal axes: nothing but the identity brings it onto itself nearby.
Mesh bean() {
  Mesh mesh = quad_torus(60, 30, 2, 0.7);
  for (Vec3& p : mesh.positions) {
    p.x() *= 1.3;
    p.z() += 0.15 * p.x() * p.x() + 0.1 * p.y();
  }
  return mesh;
}

struct Motion {
  Mat3 rotation;
  Vec3 translation;
};
Motion motion(double degrees, const Vec3& shift) {
  return {Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vec3(1, 2, -1).normalized()).toRotationMatrix(), shift};
}

template <class Shape>
Shape moved(Shape shape, const Motion& m) {
  for (Vec3& p : shape.positions) p = m.rotation * p + m.translation;
  return shape;
}

/// The motion back is found: points return to where they were.
double largest_error(const Alignment& found, const Motion& m, const std::vector<Vec3>& positions) {
  double largest = 0;
  for (const Vec3& p : positions)
    largest = std::max(largest, (found.rotation * (m.rotation * p + m.translation) + found.translation - p).norm());
  return largest;
}

TEST(Align, UndoesAMotionOfAMesh) {
  const Mesh reference = bean();
  for (const double degrees : {1.0, 8.0, 20.0}) {
    const Motion m = motion(degrees, {0.1, -0.2, 0.15});
    const Alignment found = align(moved(reference, m), reference);
    EXPECT_TRUE(found.converged);
    EXPECT_LT(largest_error(found, m, reference.positions), 1e-6);
    EXPECT_LT(found.rms_after, 1e-6);
    EXPECT_GT(found.rms_before, 0.01);
    EXPECT_LT((found.rotation * found.rotation.transpose() - Mat3::Identity()).norm(), 1e-12);
    EXPECT_GT(found.rotation.determinant(), 0);
  }
}

TEST(Align, FarFromTheOrigin) {
  Mesh reference = bean();
  for (Vec3& p : reference.positions) p += Vec3(6e5, 5e6, 100);
  Motion m = motion(3, Vec3::Zero());
  m.translation = Vec3(6e5, 5e6, 100) - m.rotation * Vec3(6e5, 5e6, 100) + Vec3(0.2, 0.1, 0);
  const Alignment found = align(moved(reference, m), reference);
  EXPECT_LT(largest_error(found, m, reference.positions), 1e-5);
}

/// The motion found is one of the world, whatever frames the shapes are stored in.
TEST(Align, OfShapesInFramesOfTheirOwn) {
  const Mesh reference = bean();
  const Motion m = motion(5, {0.1, -0.2, 0.15});
  const Mesh shape = moved(reference, m);
  const Frame here{Vec3(3, -2, 1), 2}, there{Vec3(-1, 0.5, 4), -1};
  for (const auto& [a, b] : {std::pair{here, there}, std::pair{there, here}, std::pair{here, here}}) {
    const Alignment found = align(in_frame(shape, a), in_frame(reference, b));
    EXPECT_LT(largest_error(found, m, reference.positions), 1e-6);
    const Mesh back = moved_by(in_frame(shape, a), found);
    for (std::size_t v = 0; v < back.positions.size(); ++v)
      ASSERT_LT((a.to_world(back.positions[v]) - reference.positions[v]).norm(), 1e-6);
  }
}

/// Σ' R w = R Σ w for every w.
TEST(MovedBy, TurnsCovariances) {
  Random random(9);
  Mesh mesh = bean();
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) mesh.covariances.push_back(random.covariance(0.1, 3));
  Alignment turn;
  turn.rotation = motion(70, {}).rotation;
  const Mesh turned = moved_by(mesh, turn);
  ASSERT_EQ(turned.covariances.size(), mesh.covariances.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3 w = random.vector();
    EXPECT_LT((turned.covariances[v] * Vec3(turn.rotation * w) - turn.rotation * (mesh.covariances[v] * w)).norm(),
              1e-14);
  }
}

TEST(Align, PointsOntoAMeshAndOntoPoints) {
  const Mesh reference = bean();
  PointCloud cloud;
  cloud.positions = reference.positions;
  const Motion m = motion(4, {0.05, 0.02, -0.03});
  EXPECT_LT(largest_error(align(moved(cloud, m), reference), m, cloud.positions), 1e-6);
  EXPECT_LT(largest_error(align(moved(cloud, m), cloud), m, cloud.positions), 1e-6);
}

TEST(Align, WhatHasNoCounterpartDoesNotPull) {
  const Mesh reference = bean();
  const Motion m = motion(5, {0.1, 0.1, 0});
  Mesh shape = moved(reference, m);
  const auto n = static_cast<Index>(shape.positions.size());
  for (const Vec3& p : sphere(2).positions) shape.positions.push_back(p + Vec3(9, 0, 0));  // 6 % of the area
  const Mesh ball = sphere(2);
  for (std::size_t f = 0; f < ball.faces.size(); ++f)
    shape.faces.add(ball.faces[f][0] + n, ball.faces[f][1] + n, ball.faces[f][2] + n);
  EXPECT_LT(largest_error(align(shape, reference), m, reference.positions), 1e-5);
}

TEST(Align, ASphereMayTurnButComesHome) {
  Mesh shape = sphere(4);
  for (Vec3& p : shape.positions) p += Vec3(0.2, -0.1, 0.05);
  const Alignment found = align(shape, sphere(4));
  EXPECT_LT((found.rotation * Vec3(0.2, -0.1, 0.05) + found.translation).norm(), 1e-3);
}

TEST(Align, SameForAnyNumberOfThreads) {
  const Mesh reference = bean();
  const Mesh shape = moved(reference, motion(8, {0.1, 0, 0}));
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  EXPECT_EQ(align(shape, reference, {}, one).rotation, align(shape, reference, {}, four).rotation);
}

TEST(Align, EmptyShapesAndBadOptionsAreRefused) {
  EXPECT_THROW(align(Mesh{}, bean()), InvariantError);
  EXPECT_THROW(align(bean(), Mesh{}), InvariantError);
  EXPECT_THROW(align(bean(), PointCloud{}), InvariantError);
  AlignOptions options;
  options.trim = 1;
  EXPECT_THROW(options.check(), OptionError);
}

}  // namespace
}  // namespace gpsrecon::test
