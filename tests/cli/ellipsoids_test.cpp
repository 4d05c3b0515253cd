#include <gpsrecon/core/ellipsoids.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/core/mesh_topology.h>
#include <Eigen/Geometry>
#include <numbers>

namespace gpsrecon::test {

using namespace internal;
namespace {

Mixture three_gaussians() {
  Mixture mixture;
  mixture.means = {{0, 0, 0}, {10, -3, 2}, {-4, 5, 20}};
  mixture.covariances = {Sym3::identity(0.25), Sym3::diagonal(4, 1, 0.01), {2, 0.5, -0.3, 1, 0.2, 0.5}};
  mixture.weights = {1, 2, 3};
  mixture.frame = {Vec3(1, 2, 3), 4};
  return mixture;
}

double signed_volume(const Mesh& mesh, std::size_t first_face, std::size_t end_face) {
  double volume = 0;
  for (std::size_t f = first_face; f < end_face; ++f) {
    const auto face = mesh.faces[f];
    volume += mesh.positions[face[0]].dot(mesh.positions[face[1]].cross(mesh.positions[face[2]])) / 6;
  }
  return volume;
}

TEST(Ellipsoids, vertices_have_the_asked_for_mahalanobis_distance) {
  const Mixture mixture = three_gaussians();
  for (const double scale : {0.5, 1.0, 3.0}) {
    const Mesh mesh = ellipsoid_mesh(mixture, {.scale = scale, .level = 2});
    validate(mesh);
    EXPECT_EQ(mesh.frame, mixture.frame);
    const std::size_t per_gaussian = mesh.positions.size() / mixture.size();
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const FactoredGaussian g(mixture.component(v / per_gaussian));
      EXPECT_NEAR(squared_mahalanobis(g, mesh.positions[v]), scale * scale, 1e-9);
    }
  }
}

TEST(Ellipsoids, are_closed_spheres_one_per_gaussian) {
  const Mixture mixture = three_gaussians();
  for (const int level : {0, 1, 3}) {
    const Mesh mesh = ellipsoid_mesh(mixture, {.level = level});
    const Topology t = topology(mesh.faces, mesh.positions.size());
    EXPECT_EQ(t.faces, 3u * 20 * (1u << (2 * level)));
    EXPECT_EQ(t.components, 3u);
    EXPECT_EQ(t.euler, 6);
    EXPECT_EQ(t.boundary_edges, 0u);
    EXPECT_TRUE(t.manifold());
  }
}

TEST(Ellipsoids, volume_tends_to_that_of_the_ellipsoid_by_second_order) {
  const Mixture mixture = three_gaussians();
  for (std::size_t s = 0; s < mixture.size(); ++s) {
    const double exact = 4 * std::numbers::pi / 3 * std::sqrt(mixture.covariances[s].determinant());
    double last_error = 0;
    for (const int level : {1, 2, 3, 4}) {
      const Mesh mesh = ellipsoid_mesh(mixture, {.level = level});
      const std::size_t faces = mesh.faces.size() / mixture.size();
      const double volume = signed_volume(mesh, s * faces, (s + 1) * faces);
      const double error = 1 - volume / exact;  // inscribed: the volume is smaller
      EXPECT_GT(error, 0);
      if (level > 1) {
        EXPECT_NEAR(last_error / error, 4, 0.5);
      }
      last_error = error;
    }
  }
}

TEST(Ellipsoids, colour_is_the_smallest_axis) {
  Mixture mixture = three_gaussians();
  const Mesh mesh = ellipsoid_mesh(mixture);
  ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
  EXPECT_EQ(mesh.colors[mesh.colors.size() / 3], (Color{0, 0, 255}));
  EXPECT_TRUE(ellipsoid_mesh(mixture, {.colors = false}).colors.empty());
}

TEST(Ellipsoids, bad_options_are_refused) {
  EXPECT_THROW(ellipsoid_mesh({}, {.scale = 0}), OptionError);
  EXPECT_THROW(ellipsoid_mesh({}, {.scale = NAN}), OptionError);
  EXPECT_THROW(ellipsoid_mesh({}, {.level = -1}), OptionError);
  EXPECT_THROW(ellipsoid_mesh({}, {.level = 6}), OptionError);
  EXPECT_TRUE(ellipsoid_mesh({}).positions.empty());
}

}  // namespace
}  // namespace gpsrecon::test
