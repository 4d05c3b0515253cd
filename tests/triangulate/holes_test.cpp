#include <gmock/gmock.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/self_intersections.h>
#include <gpsrecon/triangulate/holes.h>

#include "support/meshes.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::part;
using test::SampledShape;
using test::tangent_discs;
using testing::Each;
using testing::UnorderedElementsAre;

/// A flat sheet of discs in a slightly sheared grid, n by n, spacing 1, in the plane z = 0.
SampledShape sheet(int n) {
  SampledShape s;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) s.points.emplace_back(i + 0.1 * (j % 3), j + 0.1 * (i % 2), 0);
  s.normals.assign(s.points.size(), Vec3::UnitZ());
  s.area = static_cast<double>(n * n);
  return s;
}

std::vector<double> loop_lengths(const CovMesh& mesh) {
  std::vector<double> lengths;
  for (const auto& loop : boundary_loops(build_connectivity(mesh.faces, mesh.vertices.size()))) {
    double length = 0;
    for (std::size_t k = 0; k < loop.size(); ++k)
      length += (mesh.vertices.means[loop[(k + 1) % loop.size()]] - mesh.vertices.means[loop[k]]).norm();
    lengths.push_back(length);
  }
  return lengths;
}

Mending mend(CovMesh& mesh, std::vector<Index>& component_of_vertex, const Mixture& mixture,
             const TriangulateOptions& options) {
  const Connectivity connectivity = build_connectivity(mesh.faces, mesh.vertices.size());
  return internal::mend(mesh, connectivity, component_of_vertex, mixture, options);
}

Topology topology(const CovMesh& mesh) {
  return topology(mesh.faces, mesh.vertices.size());
}

/// What filling may never harm.
void expect_sound(const Triangulation& result) {
  ASSERT_NO_THROW(validate(result.mesh));
  EXPECT_EQ(topology(result.mesh).unused_vertices, 0U);
  EXPECT_EQ(self_intersecting_faces(result.mesh.vertices.means, result.mesh.faces).size(), 0U);
  EXPECT_EQ(result.loop_reasons.size(), topology(result.mesh).boundary_loops);
  EXPECT_EQ(static_cast<std::size_t>(
                std::count(result.component_of_vertex.begin(), result.component_of_vertex.end(), no_index)),
            result.filled_vertices);
}

/// A unit sphere with three round holes, of these radii (angles), around three axes.
class HoledSphere : public testing::Test {
 protected:
  static constexpr std::array<double, 3> radius{0.25, 0.35, 0.5};
  HoledSphere()
      : mixture_(tangent_discs(part(test::fibonacci_sphere(3000), [](const Vec3& p) {
          return p.x() < std::cos(radius[0]) && p.y() < std::cos(radius[1]) && -p.z() < std::cos(radius[2]);
        }))) {}

  Mixture mixture_;
  TriangulateOptions options_;
};

TEST_F(HoledSphere, KeepsWhatIsNotAskedFor) {
  options_.holes = HolePolicy::keep;
  const Triangulation kept = triangulate(mixture_, options_);
  expect_sound(kept);
  EXPECT_THAT(kept.loop_reasons, UnorderedElementsAre(LoopReason::kept, LoopReason::kept, LoopReason::kept));
  // The smallest hole is 11 Gaussians across.
  const Triangulation automatic = triangulate(mixture_);
  EXPECT_EQ(automatic.mesh.faces, kept.mesh.faces);
  EXPECT_THAT(automatic.loop_reasons, testing::AllOf(testing::SizeIs(3), Each(LoopReason::no_points)));
  EXPECT_EQ(automatic.filled_holes, 0U);
}

TEST_F(HoledSphere, FillsLoopsUpToTheLength) {
  options_.holes = HolePolicy::keep;
  const CovMesh open = triangulate(mixture_, options_).mesh;
  std::vector<double> lengths = loop_lengths(open);
  std::sort(lengths.begin(), lengths.end());
  ASSERT_EQ(lengths.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k)  // a hole of angle r has a rim of 2π sin r, within an edge or so
    EXPECT_NEAR(lengths[k], 2 * std::numbers::pi * std::sin(radius[k]), 0.5);
  const double diagonal = bounding_box_diagonal(open.vertices.means);
  for (std::size_t k = 0; k < 3; ++k)
    for (const double factor : {1 - 1e-9, 1 + 1e-9}) {
      options_.holes = HoleRule::fill(Length::of_diagonal(factor * lengths[k] / diagonal));
      const Triangulation filled = triangulate(mixture_, options_);
      expect_sound(filled);
      const std::size_t expected = factor > 1 ? k + 1 : k;
      EXPECT_EQ(filled.filled_holes, expected);
      EXPECT_EQ(filled.filled_rims, 0U);
      EXPECT_THAT(filled.loop_reasons, testing::AllOf(testing::SizeIs(3 - expected), Each(LoopReason::too_long)));
      EXPECT_EQ(topology(filled.mesh).euler, static_cast<long>(expected) - 1);
    }
}

TEST_F(HoledSphere, AllCloseItAndTheSurfaceRunsOn) {
  options_.holes = HolePolicy::all;
  const Triangulation filled = triangulate(mixture_, options_);
  expect_sound(filled);
  const Topology t = topology(filled.mesh);
  EXPECT_EQ(t.euler, 2);
  EXPECT_EQ(t.boundary_loops, 0U);
  EXPECT_EQ(filled.filled_holes, 3U);
  EXPECT_GT(test::volume(filled.mesh.faces, filled.mesh.vertices.means), 0);
  const Mixture& vertices = filled.mesh.vertices;
  const Vec3 given = eigen_decomposition(mixture_.covariances[0]).values;
  std::size_t checked = 0;
  for (Index v = 0; v < vertices.size(); ++v) {
    if (filled.component_of_vertex[v] != no_index) continue;
    ++checked;
    // A flat cap over the largest hole would be 1 - cos 0.5 = 0.12 inside.
    EXPECT_NEAR(vertices.means[v].norm(), 1, 0.06);
    const Eigen3 e = eigen_decomposition(vertices.covariances[v]);
    EXPECT_GT(std::abs(e.vectors.col(0).dot(vertices.means[v].normalized())), std::cos(0.3));
    // All on the rim have the same Gaussian, so all inside are as thick and about as wide.
    EXPECT_NEAR(e.values[0], given[0], 1e-9 * given[0]);
    EXPECT_GT(e.values[1], given[2] / 4);
    EXPECT_LT(e.values[2], given[2] * 4);
    EXPECT_GT(vertices.weights[v], 0);
    EXPECT_LT(vertices.weights[v], 1e-3);
  }
  EXPECT_EQ(checked, filled.filled_vertices);
  EXPECT_GT(checked, 30U);
}

TEST(Holes, AHoleInASheetIsFilledInItsPlane) {
  const SampledShape holed = part(sheet(25), [](const Vec3& p) { return (p - Vec3(12, 12, 0)).norm() > 5; });
  const Mixture mixture = tangent_discs(holed);
  TriangulateOptions options;
  const Triangulation open = triangulate(mixture, options);
  expect_sound(open);
  EXPECT_THAT(open.loop_reasons, UnorderedElementsAre(LoopReason::rim, LoopReason::no_points));
  options.holes = HoleRule::fill(
      Length::of_diagonal(1.3 * 2 * std::numbers::pi * 5 / bounding_box_diagonal(open.mesh.vertices.means)));
  const Triangulation filled = triangulate(mixture, options);
  expect_sound(filled);
  EXPECT_THAT(filled.loop_reasons, UnorderedElementsAre(LoopReason::rim));
  EXPECT_EQ(topology(filled.mesh).euler, 1);
  for (Index v = 0; v < filled.mesh.vertices.size(); ++v) {
    EXPECT_NEAR(filled.mesh.vertices.means[v].z(), 0, 1e-9);
    EXPECT_NEAR(std::abs(eigen_decomposition(filled.mesh.vertices.covariances[v]).vectors(2, 0)), 1, 1e-9);
  }
  // Nothing caps a flat sheet without lying in it.
  options.holes = HolePolicy::all;
  const Triangulation all = triangulate(mixture, options);
  EXPECT_EQ(all.mesh.faces, filled.mesh.faces);
  EXPECT_THAT(all.loop_reasons, UnorderedElementsAre(LoopReason::would_intersect));
}

TEST(Holes, TheRimOfADomeIsCappedOnlyOnRequestAndWithAWarning) {
  const Mixture mixture = tangent_discs(part(test::fibonacci_sphere(3000), [](const Vec3& p) { return p.z() > 0.5; }));
  EXPECT_THAT(triangulate(mixture).loop_reasons, UnorderedElementsAre(LoopReason::rim));
  std::vector<std::string> warnings;
  RunContext context;
  context.on_log = [&](LogLevel level, const std::string& text) {
    if (level == LogLevel::warning) warnings.push_back(text);
  };
  TriangulateOptions options;
  options.holes = HolePolicy::all;
  const Triangulation capped = triangulate(mixture, options, context);
  expect_sound(capped);
  EXPECT_EQ(capped.filled_rims, 1U);
  EXPECT_EQ(topology(capped.mesh).euler, 2);
  EXPECT_GT(test::volume(capped.mesh.faces, capped.mesh.vertices.means), 0);
  EXPECT_EQ(warnings.size(), 1U);
}

/// mend() on a closed triangulation of a sphere without the faces around some of its vertices.
struct Opened {
  Mixture mixture;
  CovMesh mesh;
  std::vector<Index> component;

  explicit Opened(const std::function<bool(const Vec3&)>& missing)
      : mixture(tangent_discs(test::fibonacci_sphere(2000))) {
    const FaceList full = triangulate(mixture).mesh.faces;
    mesh.vertices = mixture;
    for (std::size_t f = 0; f < full.size(); ++f)
      if (std::none_of(full[f].begin(), full[f].end(), [&](Index v) { return missing(mixture.means[v]); }))
        mesh.faces.add(full[f]);
    component.resize(mixture.size());
    std::iota(component.begin(), component.end(), Index{0});
  }
  Mixture without(const std::function<bool(const Vec3&)>& missing) const {
    std::vector<Index> kept;
    for (Index v = 0; v < mixture.size(); ++v)
      if (!missing(mixture.means[v])) kept.push_back(v);
    return select(mixture, kept);
  }
};

TEST(Holes, LeftOverGaussiansSupportAPatch) {
  // Discs of 0.6 spacings reach 1.8; the gap left by a disc of radius r is open to about r + 1/2 from its middle.
  const double spacing = test::fibonacci_sphere(2000).spacing();
  for (const double r : {0.5, 3.5}) {
    const auto missing = [&](const Vec3& p) { return (p - Vec3(1, 0, 0)).norm() < r * spacing; };
    Opened opened(missing);
    ASSERT_EQ(topology(opened.mesh).boundary_loops, 1U);
    for (const bool leftovers : {true, false}) {
      CovMesh mesh = opened.mesh;
      std::vector<Index> component = opened.component;
      const Mixture support = leftovers ? opened.mixture : opened.without(missing);
      const Mending mending = mend(mesh, component, support, {});
      const bool covered = leftovers || r < 1;
      EXPECT_EQ(mending.filled, covered ? 1U : 0U) << r << leftovers;
      EXPECT_EQ(topology(mesh).boundary_loops, covered ? 0U : 1U);
    }
  }
}

TEST(Holes, SelfIntersectionsAreReplaced) {
  Opened sphere([](const Vec3&) { return false; });
  // Neighbours that trade places turn the faces around them over.
  CovMesh& mesh = sphere.mesh;
  const Index a = mesh.faces[1234][0], b = mesh.faces[1234][1];
  std::swap(mesh.vertices.means[a], mesh.vertices.means[b]);
  ASSERT_GT(self_intersecting_faces(mesh.vertices.means, mesh.faces).size(), 0U);
  const Mending mending = mend(mesh, sphere.component, sphere.mixture, {});
  EXPECT_GE(mending.untangled, 1U);
  EXPECT_EQ(self_intersecting_faces(mesh.vertices.means, mesh.faces).size(), 0U);
  EXPECT_EQ(topology(mesh).euler, 2);
  EXPECT_EQ(topology(mesh).boundary_loops, 0U);
  ASSERT_NO_THROW(validate(mesh));
  EXPECT_NEAR(test::volume(mesh.faces, mesh.vertices.means), 4 * std::numbers::pi / 3, 0.03);
}

TEST(Holes, WithoutSelfIntersectionsNothingIsReplaced) {
  Opened sphere([](const Vec3&) { return false; });
  const CovMesh before = sphere.mesh;
  const Mending mending = mend(sphere.mesh, sphere.component, sphere.mixture, {});
  EXPECT_EQ(mending.untangled, 0U);
  EXPECT_EQ(sphere.mesh.faces, before.faces);
  EXPECT_EQ(sphere.mesh.vertices.means, before.vertices.means);
}

TEST(Holes, EveryReasonHasItsName) {
  EXPECT_EQ(name_of(LoopReason::rim), "rim");
  EXPECT_EQ(name_of(LoopReason::no_points), "no_points");
  EXPECT_EQ(name_of(LoopReason::too_long), "too_long");
  EXPECT_EQ(name_of(LoopReason::kept), "kept");
  EXPECT_EQ(name_of(LoopReason::no_patch), "no_patch");
  EXPECT_EQ(name_of(LoopReason::would_intersect), "would_intersect");
}

}  // namespace
}  // namespace gpsrecon
