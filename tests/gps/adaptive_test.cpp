// Adaptive refinement: how far the triangles are from the surface, whether they fit together, how many there are.

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/gps/adaptive.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/gps/subdivide.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/measure/distance.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "support/covmeshes.h"
#include "support/data_files.h"
#include "support/temporary_folder.h"

namespace gpsrecon {

using namespace internal;
namespace {

using namespace test;

/// Points of the limit surface on a regular grid of every patch, far denser than the samples of the refinement.
std::vector<Vec3> dense_samples(const SurfaceEvaluator& surface, bool triangular, int parts) {
  std::vector<SurfaceParameter> parameters;
  for (Index patch = 0; patch < surface.patch_count(); ++patch)
    for (int i = 0; i <= parts; ++i)
      for (int j = 0; j <= (triangular ? parts - i : parts); ++j)
        parameters.push_back({patch, static_cast<double>(i) / parts, static_cast<double>(j) / parts});
  std::vector<Vec3> points;
  for (const SurfacePoint& p : surface.evaluate(parameters)) points.push_back(p.position);
  return points;
}

Mesh as_mesh(const Tessellation& t) {
  Mesh mesh;
  mesh.positions = t.positions;
  mesh.faces = t.faces;
  return mesh;
}

double largest_distance(const Mesh& mesh, const std::vector<Vec3>& points) {
  const SurfaceDistance distance(mesh);
  double largest = 0;
  for (const ClosestPoint& c : distance.distances(points)) largest = std::max(largest, c.distance);
  return largest;
}

/// How far the triangles' own points are from the surface: to those sampled at their parameters.
double largest_deviation_of_triangles(const Tessellation& t, const std::vector<Vec3>& dense) {
  Mesh cloud;
  cloud.positions = dense;
  double largest = 0;
  for (std::size_t f = 0; f < t.faces.size(); ++f) {
    const auto v = t.faces[f];
    const Vec3 middle = (t.positions[v[0]] + t.positions[v[1]] + t.positions[v[2]]) / 3;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& p : dense) nearest = std::min(nearest, (p - middle).squaredNorm());
    largest = std::max(largest, std::sqrt(nearest));
  }
  return largest;
}

struct Case {
  std::string name;
  CovMesh mesh;
  Scheme scheme = Scheme::loop;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

Mesh polygon_box() {
  // A box with a pentagon and a triangle among its quadrilaterals: an edge of the top is shared with a corner cut off.
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(2 * (i & 1), i >> 1 & 1, i >> 2 & 1);
  mesh.positions.emplace_back(1, 0, 1);
  for (const std::vector<Index>& face : std::vector<std::vector<Index>>{
           {0, 2, 3, 1}, {4, 8, 7, 6}, {8, 5, 7}, {0, 1, 5, 8, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    mesh.faces.add(face);
  return mesh;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"octahedron", with_equal_covariances(octahedron(), Sym3::identity(0.1))});
  all.push_back({"torus", infer_covariances(torus(15, 10)).mesh});
  all.push_back({"irregular", with_random_covariances(irregular_sphere(3), 2, 0.01, 0.2)});
  all.push_back({"holes", with_random_covariances(with_holes(irregular_sphere(4), 11), 3, 0.01, 0.2)});
  all.push_back({"sharp", infer_covariances(with_holes(irregular_sphere(5), 7), {.bias = 1e-3}).mesh});
  all.push_back({"triangle", with_random_covariances(fan(3, false, 1), 4, 0.01, 1)});
  all.push_back({"box", with_random_covariances(polygon_box(), 5, 0.05, 0.5), Scheme::catmull_clark});
  return all;
}

class Adaptive : public testing::TestWithParam<Case> {};

TEST_P(Adaptive, StaysWithinTheToleranceAndFitsTogether) {
  const CovMesh control = with_rules(GetParam().mesh, {.scheme = GetParam().scheme});
  const SurfaceEvaluator surface(control);
  const std::vector<Vec3> dense = dense_samples(surface, GetParam().scheme == Scheme::loop, 40);
  const Topology before = topology(control.faces, control.vertices.size());
  const double diagonal = bounding_box_diagonal(control.vertices.means);
  std::size_t coarser = 0;
  for (const double relative : {1e-2, 1e-3, 2e-4}) {
    const double tolerance = relative * diagonal;
    const Tessellation t = tessellate(surface, control, tolerance, 11);
    EXPECT_EQ(t.unresolved, 0u);
    EXPECT_LE(largest_distance(as_mesh(t), dense), tolerance) << relative;
    const Topology after = topology(t.faces, t.positions.size());
    EXPECT_TRUE(after.manifold());
    EXPECT_EQ(after.euler, before.euler);
    EXPECT_EQ(after.components, before.components);
    EXPECT_EQ(after.boundary_loops, before.boundary_loops);
    EXPECT_EQ(after.unused_vertices, before.unused_vertices);
    EXPECT_GT(after.vertices, coarser);
    coarser = after.vertices;
    // Every vertex is the point of the surface at its parameter.
    for (std::size_t v = 0; v < t.parameters.size(); ++v)
      ASSERT_LT((surface.evaluate(t.parameters[v]).position - t.positions[v]).norm(), 1e-14);
    // And the triangles do not reach beyond the surface. (With sharp edges the samples are too far apart to tell.)
    if (relative == 1e-2 && GetParam().name != "sharp") {
      EXPECT_LE(largest_deviation_of_triangles(t, dense), 2 * tolerance);
    }
  }
}

TEST_P(Adaptive, DoesNotDependOnThreads) {
  const CovMesh control = with_rules(GetParam().mesh, {.scheme = GetParam().scheme});
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  const SurfaceEvaluator surface(control);
  const Tessellation a = tessellate(surface, control, 1e-3, 11, one), b = tessellate(surface, control, 1e-3, 11, four);
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.positions, b.positions);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Adaptive, testing::ValuesIn(cases()),
                         [](const auto& parameter) { return parameter.param.name; });

TEST(Adaptive, LeavesFlatPlacesCoarse) {
  Mesh flat = grid(6, 5);
  CovMesh control = with_random_covariances(flat, 3, 0.3, 1);
  for (Sym3& c : control.vertices.covariances) c.xz = c.yz = 0;  // a plane; only its rim is curved
  const SurfaceEvaluator surface(control);
  const Tessellation t = tessellate(surface, control, 1e-3, 11);
  std::size_t inside = 0;
  for (std::size_t v = flat.positions.size(); v < t.parameters.size(); ++v) {
    const Vec3& p = t.positions[v];
    if (p.x() > 1 && p.x() < 5 && p.y() > 1 && p.y() < 4) ++inside;
  }
  EXPECT_EQ(inside, 0u);
}

TEST(Adaptive, NeedsFewerVerticesThanUniformLevels) {
  Mesh bump = grid(12, 12);
  bump.positions[6 * 13 + 6].z() = 2;
  const CovMesh control = with_equal_covariances(bump, Sym3::identity());
  const Mesh fine = subdivide(control, {.tolerance = Length::scene(2e-3)});
  int level = 0;
  const SurfaceEvaluator surface(control);
  const std::vector<Vec3> dense = dense_samples(surface, true, 40);
  EXPECT_LE(largest_distance(fine, dense), 2e-3);
  Mesh uniform = subdivide(control, {.levels = level});
  while (largest_distance(uniform, dense) > 2e-3) uniform = subdivide(control, {.levels = ++level});
  EXPECT_LT(4 * fine.positions.size(), uniform.positions.size()) << "level " << level;
}

TEST(Adaptive, GivesWhatUniformRefinementGives) {
  CovMesh control = with_random_covariances(with_holes(irregular_sphere(4), 11), 3, 0.05, 0.2);
  control.vertices.sigma0 = 0.05;
  for (std::size_t v = 0; v < control.vertices.size(); ++v) {
    const Vec3& p = control.vertices.means[v];
    const auto byte = [](double x) { return static_cast<std::uint8_t>(127 + 100 * std::clamp(x, -1.0, 1.0)); };
    control.vertices.colors.push_back({byte(p.x()), byte(p.y()), byte(p.z())});
  }
  std::vector<double> heights, labels;
  for (const Vec3& p : control.vertices.means) {
    heights.push_back(p.z());
    labels.push_back(p.x() > 0 ? 1 : 0);
  }
  control.vertices.scalars = {{"height", heights, ScalarKind::quantity}, {"class", labels, ScalarKind::label}};
  // The vertices of the control mesh and the middles of its edges, as far as these were split, are those of level one.
  const Mesh fine = subdivide(control, {.tolerance = Length::scene(1e-3), .curvature = true, .covariances = true});
  const Mesh uniform = subdivide(control, {.levels = 1, .curvature = true, .covariances = true});
  ASSERT_EQ(fine.scalars.size(), uniform.scalars.size());
  std::size_t shared = 0;
  for (std::size_t a = 0; a < uniform.positions.size(); ++a)
    for (std::size_t b = 0; b < fine.positions.size(); ++b) {
      if ((uniform.positions[a] - fine.positions[b]).norm() > 1e-12) continue;
      ++shared;
      EXPECT_LT((uniform.normals[a] - fine.normals[b]).norm(), 1e-9);
      EXPECT_NEAR(uniform.sigma[a], fine.sigma[b], 1e-9);
      EXPECT_LT((uniform.covariances[a].matrix() - fine.covariances[b].matrix()).norm(), 1e-12);
      EXPECT_EQ(uniform.colors[a], fine.colors[b]);
      for (std::size_t c = 0; c < fine.scalars.size(); ++c) {
        EXPECT_EQ(uniform.scalars[c].name, fine.scalars[c].name);
        if (fine.scalars[c].name.size() == 3) continue;  // directions have either sign
        const double x = uniform.scalars[c].values[a], y = fine.scalars[c].values[b];
        EXPECT_NEAR(x, y, 1e-7 * (1 + std::abs(x))) << fine.scalars[c].name;
      }
    }
  EXPECT_GT(shared, control.vertices.size() + 20);
}

TEST(Adaptive, RefusesWhatMakesNoSense) {
  const CovMesh control = with_equal_covariances(octahedron(), Sym3::identity());
  EXPECT_THROW(subdivide(control, {.tolerance = Length::scene(-1)}), OptionError);
  EXPECT_THROW(subdivide(control, {.tolerance = Length::scene(std::numeric_limits<double>::infinity())}), OptionError);
  EXPECT_THROW(subdivide(control, {.limit = false, .tolerance = Length::scene(0.1)}), OptionError);
}

TEST(Curvatures, ComeInWorldUnitsAndFlagIrregularVertices) {
  CovMesh control = infer_covariances(sphere(2)).mesh;
  const Mesh local = subdivide(control, {.levels = 2, .curvature = true});
  control.vertices.frame.exponent = 4;
  const Mesh world = subdivide(control, {.levels = 2, .curvature = true});
  const std::map<std::string, double> units{
      {"mean_curvature", 16}, {"gaussian_curvature", 256}, {"k1", 16}, {"k2", 16}};
  ASSERT_EQ(local.scalars.size(), 11u);
  for (std::size_t c = 0; c < local.scalars.size(); ++c) {
    const auto unit = units.find(local.scalars[c].name);
    for (std::size_t v = 0; v < local.positions.size(); ++v)
      EXPECT_EQ(local.scalars[c].values[v], (unit == units.end() ? 1 : unit->second) * world.scalars[c].values[v]);
  }
  // Only the six vertices of valence four.
  EXPECT_EQ(local.scalars.back().name, "curvature_exact");
  EXPECT_EQ(std::count(local.scalars.back().values.begin(), local.scalars.back().values.end(), 0.0), 6);
}

TEST(Covariances, MakeTheFileACovarianceMesh) {
  const TemporaryFolder folder;
  CovMesh control = with_random_covariances(irregular_sphere(2, 10), 3, 0.01, 0.2);
  control.vertices.frame.exponent = 3;
  const Mesh mesh = subdivide(control, {.levels = 1, .covariances = true});
  const std::string path = folder / "fine.ply";
  write_mesh(mesh, path);
  const CovMesh read = read_covmesh(path);
  EXPECT_EQ(read.faces, mesh.faces);
  ASSERT_EQ(read.vertices.size(), mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    EXPECT_EQ(read.vertices.covariances[v], 64.0 * mesh.covariances[v]);
}

TEST(Adaptive, StaysWithinTheToleranceOnAnInferredScan) {
  GPSRECON_DATA_FILE(file, "meshes/spot.obj");
  CovMesh control = infer_covariances(read_mesh(file.string())).mesh;
  const double tolerance = 5e-4 * bounding_box_diagonal(control.vertices.means);
  const SurfaceEvaluator surface(control);
  const Tessellation t = tessellate(surface, control, tolerance, 11);
  EXPECT_LE(largest_distance(as_mesh(t), dense_samples(surface, true, 12)), tolerance);
  EXPECT_TRUE(topology(t.faces, t.positions.size()).manifold());
}

}  // namespace
}  // namespace gpsrecon
