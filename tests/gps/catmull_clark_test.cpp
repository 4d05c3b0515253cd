#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/refined_parameters.h>
#include <gpsrecon/gps/subdivide.h>
#include <gtest/gtest.h>

#include <map>

#include "meshes.h"

// Refinement by Catmull and Clark's scheme. Its limit evaluated at arbitrary places is compared with OpenSubdiv in
// evaluate_test.cpp.

namespace gpsrecon::test {
namespace {

constexpr EvaluateOptions catmull_clark{.scheme = Scheme::catmull_clark};

Mesh polygons(std::vector<Vec3> positions, const std::vector<std::vector<Index>>& faces) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  for (const auto& f : faces) mesh.faces.add(f);
  return mesh;
}

Mesh cube() {
  return polygons({{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}},
                  {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

/// A prism with a roof: pentagons at its ends, quadrilaterals, and triangles where one end is a fan.
Mesh house() {
  Mesh mesh = polygons({{0, 0, 0},
                        {2, 0, 0},
                        {2, 0, 1},
                        {1, 0, 2},
                        {0, 0, 1},
                        {0, 3, 0},
                        {2, 3, 0},
                        {2, 3, 1},
                        {1, 3, 2},
                        {0, 3, 1},
                        {1, 3.5, 0.8}},
                       {{0, 1, 2, 3, 4},
                        {1, 0, 5, 6},
                        {2, 1, 6, 7},
                        {3, 2, 7, 8},
                        {4, 3, 8, 9},
                        {0, 4, 9, 5},
                        {6, 5, 10},
                        {7, 6, 10},
                        {8, 7, 10},
                        {9, 8, 10},
                        {5, 9, 10}});
  return mesh;
}

/// nx by ny quadrilaterals, slightly bent.
Mesh quad_grid(Index nx, Index ny) {
  Mesh mesh;
  for (Index i = 0; i <= nx; ++i)
    for (Index j = 0; j <= ny; ++j) mesh.positions.emplace_back(i, j, 0.1 * i * i - 0.07 * i * j);
  const auto at = [ny](Index i, Index j) { return i * (ny + 1) + j; };
  for (Index i = 0; i < nx; ++i)
    for (Index j = 0; j < ny; ++j)
      mesh.faces.add(std::vector<Index>{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  return mesh;
}

/// A closed fan of n triangles around a vertex, and one below.
Mesh double_pyramid(Index n) {
  Mesh mesh;
  mesh.positions = {{0, 0, 1}, {0, 0, -1}};
  for (Index i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0.1 * std::cos(3 * angle));
  }
  for (Index i = 0; i < n; ++i) {
    const Index a = 2 + i, b = 2 + (i + 1) % n;
    mesh.faces.add(0, a, b);
    mesh.faces.add(1, b, a);
  }
  return mesh;
}

std::map<std::string, Mesh> shapes() {
  return {{"cube", cube()},
          {"house", house()},
          {"grid", quad_grid(3, 2)},
          {"one quad", quad_grid(1, 1)},
          {"tetrahedron", tetrahedron()},
          {"valence 5", double_pyramid(5)},
          {"valence 64", double_pyramid(64)}};
}

Mesh refined(const CovMesh& mesh, int levels, bool limit = true, const RunContext& context = {}) {
  return subdivide(mesh, {.scheme = Scheme::catmull_clark, .levels = levels, .limit = limit}, context);
}

TEST(CatmullClark, OneStepOnACubeIsTheTextbooks) {
  const CovMesh mesh = with_equal_covariances(cube(), Sym3::identity(0.1));
  const Mesh fine = refined(mesh, 1, false);
  ASSERT_EQ(fine.positions.size(), 8U + 12 + 6);
  ASSERT_EQ(fine.faces.size(), 24U);
  EXPECT_TRUE(fine.faces.all_of_size(4));
  // A corner: (F + 2R + (n - 3)P) / n with face centres averaging 1/3 and edge middles 2/3; an edge: the mean of its
  // ends and the centres beside it; a face: its centre.
  for (std::size_t v = 0; v < 8; ++v) EXPECT_LT((fine.positions[v] - 5.0 / 9 * mesh.vertices.means[v]).norm(), 1e-14);
  std::map<int, int> edges_and_faces;
  for (std::size_t v = 8; v < 26; ++v) {
    const Vec3 p = fine.positions[v].cwiseAbs();
    const int zeros = static_cast<int>((p.array() < 1e-14).count());
    ++edges_and_faces[zeros];
    EXPECT_NEAR(p.sum(), zeros == 1 ? 1.5 : 1, 1e-14);
  }
  EXPECT_EQ(edges_and_faces, (std::map<int, int>{{1, 12}, {2, 6}}));
}

TEST(CatmullClark, EveryShapeKeepsItsTopologyInQuadrilaterals) {
  for (const auto& [name, mesh] : shapes()) {
    SCOPED_TRACE(name);
    const Topology before = topology(mesh.faces, mesh.positions.size());
    for (const int levels : {1, 2, 3}) {
      const Mesh fine = refined(with_random_covariances(mesh, 5), levels);
      const Topology after = topology(fine.faces, fine.positions.size());
      EXPECT_TRUE(fine.faces.all_of_size(4));
      EXPECT_EQ(fine.faces.size(), mesh.faces.corners.size() << (2 * (levels - 1)));
      EXPECT_TRUE(after.manifold());
      EXPECT_EQ(after.euler, before.euler);
      EXPECT_EQ(after.components, before.components);
      EXPECT_EQ(after.boundary_loops, before.boundary_loops);
      EXPECT_EQ(after.unused_vertices, before.unused_vertices);
    }
  }
}

TEST(CatmullClark, WeightsAreNotNegativeAndSumToOne) {
  for (const auto& [name, mesh] : shapes()) {
    SCOPED_TRACE(name);
    const std::size_t n = mesh.positions.size();
    const LimitSurface surface(mesh.faces, n, 2, catmull_clark);
    std::vector<double> sum(surface.sample_count(), 0);
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<double> one(n, 0);
      one[i] = 1;
      const std::vector<double> weight = surface.to_samples<double>(one);
      for (std::size_t s = 0; s < sum.size(); ++s) {
        EXPECT_GE(weight[s], 0);
        sum[s] += weight[s];
      }
    }
    for (const double s : sum) EXPECT_NEAR(s, 1, 1e-14);
  }
}

/// The masks at the refined vertices against the evaluation there, which goes another way.
TEST(CatmullClark, SamplesAreTheSurfaceAtTheirParameters) {
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp})
    for (const auto& [name, mesh] : shapes()) {
      SCOPED_TRACE(name);
      const CovMesh control = with_random_covariances(mesh, 6);
      EvaluateOptions rules = catmull_clark;
      rules.corners = corners;
      const SurfaceEvaluator evaluator(control, rules);
      for (const int levels : {1, 3}) {
        const LimitSurface surface(mesh.faces, mesh.positions.size(), levels, rules);
        const SurfaceSamples samples = surface.evaluate(control.vertices);
        const auto places =
            refined_parameters(mesh.faces, surface.faces(), surface.sample_count(), levels, Scheme::catmull_clark);
        for (std::size_t s = 0; s < places.size(); ++s) {
          const SurfacePoint p = evaluator.evaluate(places[s]);
          EXPECT_LT((samples.positions[s] - p.position).norm(), 1e-12);
          if (p.normal.isZero(0)) continue;
          EXPECT_LT((samples.normals[s] - p.normal).norm(), 1e-9);
        }
      }
    }
}

TEST(CatmullClark, LimitPointsStayWhereTheyAre) {
  const CovMesh control = with_random_covariances(house(), 7);
  const Mesh coarse = refined(control, 1), fine = refined(control, 4);
  for (std::size_t v = 0; v < coarse.positions.size(); ++v)
    EXPECT_LT((coarse.positions[v] - fine.positions[v]).norm(), 1e-13);
}

TEST(CatmullClark, CommutesWithAffineMaps) {
  Mat3 a;
  a << 1.2, 0.3, -0.4, 0.1, 0.7, 0.2, -0.3, 0.5, 1.6;
  const Vec3 shift(3, -2, 1);
  const CovMesh control = with_random_covariances(house(), 8);
  CovMesh mapped = control;
  for (std::size_t i = 0; i < mapped.vertices.size(); ++i) {
    mapped.vertices.means[i] = a * control.vertices.means[i] + shift;
    const Mat3 covariance = a * control.vertices.covariances[i].matrix() * a.transpose();
    mapped.vertices.covariances[i] = {covariance(0, 0), covariance(0, 1), covariance(0, 2),
                                      covariance(1, 1), covariance(1, 2), covariance(2, 2)};
  }
  const Mesh one = refined(control, 2), other = refined(mapped, 2);
  for (std::size_t v = 0; v < one.positions.size(); ++v)
    EXPECT_LT((a * one.positions[v] + shift - other.positions[v]).norm(), 1e-11);
}

TEST(CatmullClark, AGlobalFactorChangesNothingAndNeedlesStayFinite) {
  CovMesh control = with_random_covariances(house(), 9);
  const Mesh one = refined(control, 2);
  for (Sym3& c : control.vertices.covariances) c = 1000.0 * c;
  const Mesh scaled = refined(control, 2);
  EXPECT_LT(max_distance(one.positions, scaled.positions), 1e-12);
  for (const Mesh& mesh : {refined(with_random_covariances(house(), 10, 1e-12, 1), 3)}) {
    for (const Vec3& p : mesh.positions) EXPECT_TRUE(p.allFinite());
    for (const Vec3& n : mesh.normals) EXPECT_NEAR(n.norm(), 1, 1e-9);
  }
}

TEST(CatmullClark, NormalsFaceTheSideOfTheFaces) {
  const Mesh fine = refined(with_equal_covariances(cube(), Sym3::identity(0.1)), 3);
  for (std::size_t v = 0; v < fine.positions.size(); ++v) EXPECT_GT(fine.normals[v].dot(fine.positions[v]), 0);
}

TEST(CatmullClark, SameForAnyNumberOfThreads) {
  const CovMesh control = with_random_covariances(quad_grid(20, 20), 11);
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  const Mesh a = refined(control, 3, true, one), b = refined(control, 3, true, four);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.faces, b.faces);
}

/// Corners of a single face that is degenerate at one of them have no tangent plane of their own: then the face tells
/// the side, whichever of its corners it is.
TEST(CatmullClark, ADegenerateCornerTakesTheSideOfItsFace) {
  const std::vector<Index> order{0, 1, 2, 3};
  for (std::size_t turn = 0; turn < 4; ++turn) {
    std::vector<Index> face = order;
    std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(turn), face.end());
    const Mesh mesh = polygons({{1, 0, 0}, {0, -1, 0}, {-1, 0, 0}, {0, 0, 0}}, {face});
    const Mesh fine = refined(with_equal_covariances(mesh, Sym3::identity(0.1)), 0);
    for (const Vec3& n : fine.normals) EXPECT_LT(n.z(), -0.9);
  }
}

TEST(CatmullClark, WhatCannotBeRefinedIsRefused) {
  const CovMesh control = with_equal_covariances(house(), Sym3::identity(0.1));
  try {
    subdivide(control, {.levels = 1});
    FAIL();
  } catch (const InvariantError& error) {
    EXPECT_NE(std::string(error.what()).find("face 0 has 5 corners"), std::string::npos) << error.what();
  }
  EXPECT_THROW(refined(control, 0), OptionError);
  EXPECT_NO_THROW(refined(with_equal_covariances(cube(), Sym3::identity(0.1)), 0));
}

}  // namespace
}  // namespace gpsrecon::test
