#include <gpsrecon/scan/mesh_target.h>

#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/scan/gallery.h>
#include <gpsrecon/scan/virtual_scan.h>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace gpsrecon {

using namespace internal;
namespace {

Vec3 random_point(std::uint64_t i, double half_width) {
  const auto coordinate = [&](std::uint64_t k) { return half_width * (2 * random_uniform(5, 0, 3 * i + k) - 1); };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

Vec3 random_direction(std::uint64_t i) {
  return random_point(1'000'000 + i, 1).normalized();
}

/// The first hit among all triangles, by Cramer's rule.
double first_hit_by_trial(const Mesh& mesh, const Vec3& origin, const Vec3& direction) {
  double first = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    const Vec3 a = mesh.positions[face[0]];
    Mat3 system;
    system << mesh.positions[face[1]] - a, mesh.positions[face[2]] - a, -direction;
    if (system.determinant() == 0) continue;
    const Vec3 x = system.inverse() * (origin - a);
    if (x[0] >= 0 && x[1] >= 0 && x[0] + x[1] <= 1 && x[2] > 0) first = std::min(first, x[2]);
  }
  return first;
}

TEST(MeshTarget, FindsTheFirstOfAllHits) {
  const Mesh mesh = make_shape("knot")->mesh(0.05);
  const MeshTarget target(mesh);
  std::size_t hits = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Vec3 origin = 10 * random_direction(i), direction = (random_point(i, 3) - origin).normalized();
    const double expected = first_hit_by_trial(mesh, origin, direction);
    const std::optional<SurfaceHit> hit = target.first_hit(origin, direction);
    ASSERT_EQ(hit.has_value(), std::isfinite(expected));
    if (!hit) continue;
    ++hits;
    ASSERT_NEAR((hit->point - origin).norm(), expected, 1e-10);
    ASSERT_NEAR(hit->normal.norm(), 1, 1e-12);
  }
  EXPECT_GT(hits, 500u);
}

// The two ways to scan a shape, traced and triangulated, see the same.
TEST(MeshTarget, IsScannedAsTheShapeItIsMadeFrom) {
  const auto block = make_shape("block");
  const double tolerance = 1e-3;
  const MeshTarget target(block->mesh(tolerance));
  EXPECT_NEAR(target.diagonal(), block->diagonal(), 2 * tolerance);
  ScanOptions options;
  options.points = 5000;
  const VirtualScan scan = virtual_scan(target, options);
  ASSERT_EQ(scan.cloud.size(), 5000u);
  double cosine = 0;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    ASSERT_LE(std::abs(block->distance(scan.cloud.positions[i])), tolerance);
    cosine += block->closest(scan.cloud.positions[i]).normal.dot(scan.cloud.normals[i]) / 5000;
  }
  EXPECT_GT(cosine, 0.999);
}

TEST(MeshTarget, IsIndependentOfPlaceAndUnit) {
  Mesh mesh = make_shape("vase")->mesh(0.01);
  ScanOptions options = scan_quality(ScanQuality::s3);
  options.points = 2000;
  const VirtualScan here = virtual_scan(MeshTarget(mesh), options);
  const Vec3 shift(1 << 20, 1 << 22, -(1 << 10));
  for (Vec3& p : mesh.positions) p = 1024 * p + shift;
  const VirtualScan there = virtual_scan(MeshTarget(mesh), options);
  for (std::size_t i = 0; i < here.cloud.size(); ++i)
    ASSERT_LT(((there.cloud.positions[i] - shift) / 1024 - here.cloud.positions[i]).norm(), 1e-8);
}

TEST(MeshTarget, RefusesWhatCannotBeHit) {
  Mesh mesh;
  EXPECT_THROW(MeshTarget{mesh}, NoSurfaceError);
  mesh.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)};
  mesh.faces.add(0, 1, 2);
  EXPECT_THROW(MeshTarget{mesh}, NoSurfaceError);
  mesh.faces.add(0, 1, 7);
  EXPECT_THROW(MeshTarget{mesh}, InvariantError);
}

}  // namespace
}  // namespace gpsrecon
