// Colours, quantities and labels from points to the refined mesh.

#include <gmock/gmock.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double noise = 0.01;
constexpr std::size_t n = 8000;

/// A noisy unit sphere with a colour ramp along z, a quantity that is x where it was measured, and a label per
/// hemisphere.
PointCloud colorful_sphere() {
  PointCloud cloud = test::noisy_sphere(n, noise);
  cloud.scalars = {{"x_there", {}}, {"side", {}, ScalarKind::label}};
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& p = cloud.positions[i];
    cloud.colors.push_back({static_cast<std::uint8_t>(std::lround(127.5 + 100 * p.z())), 200, 7});
    cloud.scalars[0].values.push_back(i % 5 == 0 ? nan : p.x());
    cloud.scalars[1].values.push_back(p.y() < 0 ? 17 : -1);
  }
  return cloud;
}

TEST(ReconstructAttributes, LieWhereThePointsHaveThem) {
  const Reconstruction result = reconstruct(colorful_sphere());
  const Mesh& mesh = result.mesh;
  const double unit = mesh.frame.scale(), spacing = unit * result.covmesh.vertices.spacing;
  ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
  ASSERT_EQ(mesh.scalars.size(), 2u);
  double square_z = 0, square_x = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3 p = mesh.frame.to_world(mesh.positions[v]);
    const double z = (mesh.colors[v][0] - 127.5) / 100, x = mesh.scalars[0].values[v];
    square_z += (z - p.z()) * (z - p.z());
    square_x += (x - p.x()) * (x - p.x());
    ASSERT_LT(std::abs(z - p.z()), 3 * spacing);
    ASSERT_LT(std::abs(x - p.x()), 3 * spacing);
    ASSERT_EQ(mesh.colors[v][1], 200);
    ASSERT_EQ(mesh.colors[v][2], 7);
    ASSERT_THAT(mesh.scalars[1].values[v], testing::AnyOf(17, -1));
    if (std::abs(p.y()) > 3 * spacing) {
      ASSERT_EQ(mesh.scalars[1].values[v], p.y() < 0 ? 17 : -1);
    }
  }
  EXPECT_LT(std::sqrt(square_z / static_cast<double>(mesh.positions.size())), 0.5 * spacing);
  EXPECT_LT(std::sqrt(square_x / static_cast<double>(mesh.positions.size())), 0.5 * spacing);
}

TEST(ReconstructAttributes, ChangeNothingElse) {
  const PointCloud cloud = colorful_sphere();
  PointCloud bare;
  bare.positions = cloud.positions;
  const Reconstruction with = reconstruct(cloud), without = reconstruct(bare);
  EXPECT_EQ(with.mesh.positions, without.mesh.positions);
  EXPECT_EQ(with.mesh.faces, without.mesh.faces);
  EXPECT_TRUE(without.mesh.colors.empty());
  EXPECT_TRUE(without.mesh.scalars.empty());
  EXPECT_TRUE(without.covmesh.vertices.scalars.empty());
}

}  // namespace
}  // namespace gpsrecon
