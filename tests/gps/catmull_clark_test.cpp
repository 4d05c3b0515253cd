#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/refined_parameters.h>
#include <gpsrecon/gps/refinement_levels.h>
#include <gpsrecon/gps/subdivide.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "support/covmeshes.h"

// Refinement by Catmull and Clark's scheme. It is compared with OpenSubdiv in opensubdiv_test.cpp, evaluated at
// arbitrary parameters in opensubdiv_evaluate_test.cpp.

namespace gpsrecon::test {

using namespace internal;
namespace {

constexpr SurfaceRules catmull_clark{.scheme = Scheme::catmull_clark};

Mesh refined(const CovMesh& mesh, int levels, bool limit = true, const RunContext& context = {}) {
  return subdivide(with_rules(mesh, catmull_clark), {.levels = levels, .limit = limit}, context);
}

TEST(PolygonRefinement, RefinesInClosedFormAsBySorting) {
  for (const auto& [name, mesh] : polygon_shapes()) {
    SCOPED_TRACE(name);
    const Connectivity parent = manifold_connectivity(mesh.faces, mesh.positions.size());
    const Connectivity middle = refine_to_quads(parent), child = refine_to_quads(middle);
    const FaceList faces = refined_quads(middle);
    EXPECT_EQ(child.corners, faces.corners);
    EXPECT_TRUE(faces.all_of_size(4));
    const Connectivity sorted = manifold_connectivity(faces, child.vertex_count);
    EXPECT_EQ(child.opposite, sorted.opposite);
    EXPECT_EQ(child.face_count, sorted.face_count);
    ASSERT_EQ(child.edge_count(), sorted.edge_count());
    for (Index h = 0; h < child.corners.size(); ++h) {
      ASSERT_EQ(child.previous(child.next(h)), h);
      ASSERT_EQ(child.face(child.next(h)), child.face(h));
      const Index o = child.opposite[h];
      ASSERT_TRUE(child.edge_start[child.edge[h]] == h || child.edge_start[child.edge[h]] == o);
      if (o != no_index) {
        ASSERT_EQ(child.edge[h], child.edge[o]);
        ASSERT_EQ(child.target(h), child.source(o));
      }
    }
    for (Index v = 0; v < child.vertex_count; ++v) {
      ASSERT_EQ(child.unused(v), sorted.unused(v));
      if (child.unused(v)) continue;
      ASSERT_EQ(child.source(child.vertex_start[v]), v);
      ASSERT_EQ(child.on_boundary(v), sorted.on_boundary(v));
      Index around = 0;
      child.for_each_leaving(v, [&](Index h) { around += child.source(h) == v ? 1 : 0; });
      ASSERT_EQ(around, child.face_count[v]);
    }
  }
}

/// The rows of a table, columns and weights in one text each.
template <class Rows>
std::vector<std::string> texts(const Rows& rows) {
  std::vector<std::string> result;
  const LimitTable table = tabulate(rows);
  for (std::size_t r = 0; r < table.rows(); ++r) {
    std::ostringstream text;
    const auto [indices, weights] = table.row(r);
    for (std::size_t j = 0; j < indices.size(); ++j)
      text << indices[j] << ' ' << weights[j].position << ' ' << weights[j].u << ' ' << weights[j].v << '\n';
    result.push_back(text.str());
  }
  return result;
}

/// The limits at the vertices of a refinement without making it, against those at the vertices of the one made.
TEST(LimitRows, OfARefinementAreThoseOfItsConnectivity) {
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp}) {
    const SurfaceRules rules{.corners = corners};
    for (const auto& [name, mesh] : polygon_shapes()) {
      SCOPED_TRACE(name);
      const Connectivity parent = manifold_connectivity(mesh.faces, mesh.positions.size());
      EXPECT_EQ(texts(CatmullClarkScheme::limit(parent, rules, true)),
                texts(CatmullClarkScheme::limit(refine_to_quads(parent), rules, false)));
    }
    for (const Mesh& mesh : {tetrahedron(), grid(5, 4), fan(8, false, 4), fan(12, true, 3), irregular_sphere(3)}) {
      const Connectivity parent = triangle_connectivity(mesh.faces, mesh.positions.size());
      EXPECT_EQ(texts(LoopScheme::limit(parent, rules, true)),
                texts(LoopScheme::limit(refine_triangles(parent), rules, false)));
    }
  }
}

/// Refined without tables and with them, the surface is the same to the last bit.
TEST(LimitSurface, IsWhatSubdivideGives) {
  for (const Scheme scheme : {Scheme::loop, Scheme::catmull_clark})
    for (const int levels : {0, 1, 3}) {
      const Mesh mesh = scheme == Scheme::loop ? with_holes(irregular_sphere(4), 11) : shaken(quad_grid(4, 3), 9);
      const CovMesh control = with_random_covariances(mesh, 3);
      const Mesh refined = subdivide(with_rules(control, {.scheme = scheme}), {.levels = levels});
      const LimitSurface surface(mesh.faces, mesh.positions.size(), levels, {.scheme = scheme});
      const SurfaceSamples samples = surface.evaluate(control.vertices);
      EXPECT_EQ(samples.positions, refined.positions);
      EXPECT_EQ(samples.normals, refined.normals);
      EXPECT_EQ(samples.sigma, refined.sigma);
      EXPECT_EQ(surface.faces(), refined.faces);
    }
}

/// The entries of a step grow with the corners, not with their square.
TEST(CatmullClark, PolygonsOfAnySizeTakeLinearRoom) {
  const Index n = 20000;
  const Mesh mesh = polygon_pillow(n);
  const Connectivity topology = manifold_connectivity(mesh.faces, n);
  const auto step = tabulate(CatmullClarkScheme::step(topology, catmull_clark));
  EXPECT_EQ(step.faces.indices.size(), 2 * n);
  EXPECT_EQ(step.points.indices.size(), 5 * n + 4 * n);
  const Mesh fine = refined(with_equal_covariances(mesh, Sym3::identity(0.1)), 1);
  ASSERT_EQ(fine.positions.size(), 2 * n + 2);
  for (const Vec3& p : fine.positions) ASSERT_LT(p.norm(), 1.1);
  const SurfaceEvaluator evaluator(with_rules(with_equal_covariances(mesh, Sym3::identity(0.1)), catmull_clark));
  EXPECT_LT((evaluator.evaluate({0, 1, 1}).position - fine.positions[2 * n]).norm(), 1e-12);
}

/// At an interior vertex of two faces the limit is where deep refinement goes. (OpenSubdiv 3.5 gives another point.)
TEST(CatmullClark, InteriorVerticesOfTwoFacesConverge) {
  const Mesh mesh = interior_valence_two();
  for (const CovMesh& control : {with_equal_covariances(mesh, Sym3::identity(0.1)), with_random_covariances(mesh, 4)}) {
    const Vec3 limit = refined(control, 1).positions[4];
    double before = 0;
    for (const int levels : {2, 4, 6}) {
      EXPECT_LT((refined(control, levels).positions[4] - limit).norm(), 1e-13);
      const double distance = (refined(control, levels, false).positions[4] - limit).norm();
      if (levels > 2) {
        EXPECT_LT(distance, 0.3 * before);
      }
      before = distance;
    }
    const SurfaceEvaluator evaluator(with_rules(control, catmull_clark));
    EXPECT_LT((evaluator.evaluate({0, 0, 1}).position - limit).norm(), 1e-12);
  }
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
  for (const auto& [name, mesh] : polygon_shapes()) {
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
  for (const auto& [name, mesh] : polygon_shapes()) {
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
    for (const auto& [name, mesh] : polygon_shapes()) {
      SCOPED_TRACE(name);
      const CovMesh control = with_random_covariances(mesh, 6);
      SurfaceRules rules = catmull_clark;
      rules.corners = corners;
      const SurfaceEvaluator evaluator(with_rules(control, rules));
      for (const int levels : {1, 3}) {
        const LimitSurface surface(mesh.faces, mesh.positions.size(), levels, rules);
        const SurfaceSamples samples = surface.evaluate(control.vertices);
        const auto parameters =
            refined_parameters(mesh.faces, surface.faces(), surface.sample_count(), levels, Scheme::catmull_clark);
        for (std::size_t s = 0; s < parameters.size(); ++s) {
          if (parameters[s].patch == no_index) continue;  // no face uses it
          const SurfacePoint p = evaluator.evaluate(parameters[s]);
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
    const Mesh mesh = mesh_of({{1, 0, 0}, {0, -1, 0}, {-1, 0, 0}, {0, 0, 0}}, {face});
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
