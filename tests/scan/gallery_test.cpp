#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/scan/gallery.h>

#include <gtest/gtest.h>

#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <ostream>

namespace gpsrecon {
namespace internal {

static void PrintTo(const GalleryShape& shape, std::ostream* out) {
  *out << shape.name;
}

}  // namespace internal

using namespace internal;
namespace {

class GalleryTest : public ::testing::TestWithParam<GalleryShape> {
 protected:
  const std::unique_ptr<const Shape> shape = make_shape(GetParam().name);
  const double tolerance = 1e-3 * shape->diagonal();
  const Mesh mesh = shape->mesh(tolerance);
};

INSTANTIATE_TEST_SUITE_P(Shapes, GalleryTest, ::testing::ValuesIn(gallery()), [](const auto& instance) {
  std::string name = instance.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST_P(GalleryTest, MeshHasTheStatedTopologyAndFacesOutward) {
  const MeshMeasures report = measure_mesh(mesh);
  const Topology& topology = report.topology;
  EXPECT_EQ(topology.euler, GetParam().euler);
  EXPECT_EQ(topology.components, 1u);
  EXPECT_EQ(static_cast<int>(topology.boundary_loops), GetParam().boundaries);
  EXPECT_EQ(is_closed(topology), shape->is_closed());
  EXPECT_EQ(topology.nonmanifold_vertices + topology.nonmanifold_edges, 0u);
  const AreaSamples samples = sample_surface(mesh, 5000, 1);
  std::size_t alike = 0;
  for (std::size_t i = 0; i < samples.positions.size(); ++i) {
    const auto face = mesh.faces[samples.faces[i]];
    const Vec3 a = mesh.positions[face[0]], b = mesh.positions[face[1]], c = mesh.positions[face[2]];
    if ((b - a).cross(c - a).dot(shape->closest(samples.positions[i]).normal) > 0) ++alike;
  }
  // Within the tolerance of a crease the nearest face may be the one beyond it.
  EXPECT_GE(alike, samples.positions.size() * 995 / 1000);
}

TEST_P(GalleryTest, MeshIsWithinTheToleranceBothWays) {
  for (const Vec3& v : mesh.positions) ASSERT_LT(std::abs(shape->distance(v)), 1e-9 * shape->bounding_radius());
  const AreaSamples samples = sample_surface(mesh, 20'000, 2);
  for (const Vec3& p : samples.positions) ASSERT_LE(std::abs(shape->distance(p)), tolerance);
  const SurfaceDistance surface(mesh);
  for (const Vec3& p : sample_surface(mesh, 5'000, 3).positions) {
    const Vec3 beside = p + 0.05 * shape->bounding_radius() * Vec3(std::sin(99 * p.x()), std::sin(99 * p.y()), 0.3);
    ASSERT_LE(surface.closest(shape->closest(beside).point).distance, 1.01 * tolerance);
  }
}

TEST_P(GalleryTest, MeshConvergesWithTheSquareOfItsEdges) {
  const auto rms = [&](const Mesh& m) {
    double sum = 0;
    const AreaSamples samples = sample_surface(m, 20'000, 4);
    for (const Vec3& p : samples.positions) sum += std::pow(shape->distance(p), 2) / 20'000;
    return std::sqrt(sum);
  };
  const double coarse = rms(mesh), fine = rms(shape->mesh(tolerance / 4));
  if (coarse > 1e-12 * shape->diagonal()) {
    EXPECT_LT(fine, 0.5 * coarse);
  }
}

TEST_P(GalleryTest, DiagonalAndRadiusAreThoseOfTheMesh) {
  EXPECT_NEAR(bounding_box_diagonal(mesh.positions), shape->diagonal(), 4 * tolerance);
  double radius = 0;
  for (const Vec3& v : mesh.positions) radius = std::max(radius, v.norm());
  EXPECT_LE(radius, shape->bounding_radius() * (1 + 1e-12));
}

TEST(Gallery, VolumesAreThoseOfTheirFormulas) {
  constexpr double pi = std::numbers::pi;
  const auto volume = [](const char* name) {
    const auto shape = make_shape(name);
    const Mesh mesh = shape->mesh(1e-4 * shape->diagonal());
    return enclosed_volume(mesh.positions, mesh.faces);
  };
  EXPECT_NEAR(volume("sphere") / (4 * pi / 3), 1, 2e-3);
  EXPECT_NEAR(volume("torus") / (2 * pi * pi * 2 * 0.49), 1, 2e-3);
  // The core, its six faces, twelve quarter cylinders and eight octants.
  const double box = 8 * 1.7 * 1.2 * 0.7 + 8 * 0.3 * (1.7 * 1.2 + 1.2 * 0.7 + 0.7 * 1.7) +
                     2 * pi * 0.09 * (1.7 + 1.2 + 0.7) + 4 * pi / 3 * 0.027;
  EXPECT_NEAR(volume("rounded-box") / box, 1, 2e-3);
  // A tube is as large as the straight one, by Pappus and Guldin: its cross-section times the length of the knot.
  double length = 0;
  const auto curve = [](double t) {
    return Vec3((2 + std::cos(3 * t)) * std::cos(2 * t), (2 + std::cos(3 * t)) * std::sin(2 * t), std::sin(3 * t));
  };
  for (int i = 0; i < 100'000; ++i) length += (curve(2e-5 * pi * (i + 1)) - curve(2e-5 * pi * i)).norm();
  EXPECT_NEAR(volume("knot") / (pi * 0.25 * length), 1, 2e-3);
}

}  // namespace
}  // namespace gpsrecon
