#include <gpsrecon/core/in_frame.h>

#include <gtest/gtest.h>
#include <cmath>

#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

// Origins and places on a grid of 2^-10 within 2^10: every change of frame is exact, so all comparisons are of bits.
const Frame first{Vec3(3, -7.5, 12), 4}, second{Vec3(-100, 0.25, 31), -3};

Vec3 on_grid(test::Random& random) {
  Vec3 p = 64 * random.vector();
  for (double& x : p) x = std::nearbyint(std::ldexp(x, 10)) / 1024;
  return p;
}

Mixture some_mixture() {
  test::Random random(5);
  Mixture m;
  for (int i = 0; i < 20; ++i) {
    m.means.push_back(on_grid(random));
    m.covariances.push_back(random.covariance(0.01, 2));
    m.weights.push_back(1 + random.uniform());
    m.normals.push_back(random.vector().normalized());
    m.normal_variances.push_back(random.uniform());
    m.colors.push_back({1, 2, static_cast<std::uint8_t>(i)});
  }
  m.scalars = {{"intensity", m.weights, ScalarKind::quantity}};
  m.sigma0 = 0.125;
  m.spacing = 0.75;
  m.frame = first;
  return m;
}

PointCloud some_cloud() {
  const Mixture m = some_mixture();
  PointCloud cloud;
  cloud.positions = m.means;
  cloud.sensors.assign(m.means.rbegin(), m.means.rend());
  cloud.normals = m.normals;
  cloud.colors = m.colors;
  cloud.weights = m.weights;
  cloud.scalars = m.scalars;
  cloud.frame = first;
  return cloud;
}

Mesh some_mesh() {
  const Mixture m = some_mixture();
  Mesh mesh;
  mesh.positions = m.means;
  mesh.faces.add(0, 1, 2);
  mesh.normals = m.normals;
  mesh.colors = m.colors;
  mesh.sigma = m.weights;
  mesh.covariances = m.covariances;
  mesh.scalars = m.scalars;
  mesh.frame = first;
  return mesh;
}

std::vector<double> numbers(const std::vector<Vec3>& vectors) {
  std::vector<double> all;
  for (const Vec3& v : vectors) all.insert(all.end(), v.begin(), v.end());
  return all;
}

void expect_same_world(const std::vector<Vec3>& a, const Frame& of_a, const std::vector<Vec3>& b, const Frame& of_b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(of_a.to_world(a[i]), of_b.to_world(b[i]));
}

void expect_equal(const Mixture& a, const Mixture& b) {
  EXPECT_EQ(numbers(a.means), numbers(b.means));
  EXPECT_EQ(a.covariances, b.covariances);
  EXPECT_EQ(a.weights, b.weights);
  EXPECT_EQ(numbers(a.normals), numbers(b.normals));
  EXPECT_EQ(a.normal_variances, b.normal_variances);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.sigma0, b.sigma0);
  EXPECT_EQ(a.spacing, b.spacing);
  EXPECT_EQ(a.frame, b.frame);
}

/// Lengths over the unit of their frame, in the world, are what they were; so are covariances over its square.
TEST(InFrame, KeepsTheWorldOfAMixture) {
  const Mixture before = some_mixture(), after = in_frame(before, second);
  EXPECT_EQ(after.frame, second);
  expect_same_world(before.means, first, after.means, second);
  EXPECT_EQ(after.sigma0 * second.scale(), before.sigma0 * first.scale());
  EXPECT_EQ(after.spacing * second.scale(), before.spacing * first.scale());
  for (std::size_t s = 0; s < before.size(); ++s)
    EXPECT_EQ(after.covariances[s] * std::ldexp(1.0, 2 * second.exponent),
              before.covariances[s] * std::ldexp(1.0, 2 * first.exponent));
  expect_equal(in_frame(after, first), before);
  CovMesh mesh;
  mesh.vertices = before;
  mesh.faces.add(0, 1, 2);
  expect_equal(in_frame(mesh, second).vertices, after);
  EXPECT_EQ(in_frame(mesh, second).faces, mesh.faces);
}

TEST(InFrame, KeepsTheWorldOfAMesh) {
  const Mesh before = some_mesh(), after = in_frame(before, second);
  EXPECT_EQ(after.frame, second);
  expect_same_world(before.positions, first, after.positions, second);
  ASSERT_EQ(after.covariances.size(), before.covariances.size());
  for (std::size_t v = 0; v < before.positions.size(); ++v) {
    EXPECT_EQ(after.sigma[v] * second.scale(), before.sigma[v] * first.scale());
    EXPECT_EQ(after.covariances[v] * std::ldexp(1.0, 2 * second.exponent),
              before.covariances[v] * std::ldexp(1.0, 2 * first.exponent));
  }
  EXPECT_EQ(after.faces, before.faces);
  EXPECT_EQ(numbers(after.normals), numbers(before.normals));
  EXPECT_EQ(after.colors, before.colors);
  EXPECT_EQ(after.scalars.front().values, before.scalars.front().values);
}

TEST(InFrame, KeepsTheWorldOfACloud) {
  const PointCloud before = some_cloud(), after = in_frame(before, second);
  EXPECT_EQ(after.frame, second);
  expect_same_world(before.positions, first, after.positions, second);
  expect_same_world(before.sensors, first, after.sensors, second);
  EXPECT_EQ(numbers(after.normals), numbers(before.normals));
  EXPECT_EQ(after.weights, before.weights);
  EXPECT_EQ(after.colors, before.colors);
  EXPECT_EQ(after.scalars.front().values, before.scalars.front().values);
}

TEST(InFrame, OfItsOwnChangesNoBit) {
  PointCloud cloud = some_cloud();
  cloud.positions[0].x() = -0.0;
  EXPECT_TRUE(std::signbit(in_frame(cloud, first).positions[0].x()));
  expect_equal(in_frame(some_mixture(), first), some_mixture());
}

}  // namespace
}  // namespace gpsrecon
