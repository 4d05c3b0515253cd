// Connectivity and stencils of one Loop step.

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/loop.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <gtest/gtest.h>

#include <numeric>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>

#include "support/covmeshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

struct Named {
  std::string name;
  Mesh mesh;
};

std::vector<Named> sample_meshes() {
  Mesh two = tetrahedron();  // two components and a vertex that no face uses
  const Mesh patch = grid(3, 2);
  two.positions.emplace_back(5, 5, 5);
  const auto shift = static_cast<Index>(two.positions.size());
  for (const Vec3& p : patch.positions) two.positions.push_back(p + Vec3(9, 0, 0));
  for (std::size_t f = 0; f < patch.faces.size(); ++f)
    two.faces.add(patch.faces[f][0] + shift, patch.faces[f][1] + shift, patch.faces[f][2] + shift);
  return {{"tetrahedron", tetrahedron()},
          {"octahedron", octahedron()},
          {"irregular sphere", irregular_sphere(7)},
          {"sphere with holes", with_holes(irregular_sphere(8), 7)},
          {"torus", torus(8, 5)},
          {"grid", grid(5, 4)},
          {"one triangle", mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}})},
          {"closed fan of 12", fan(12, true, 3)},
          {"open fan of 8", fan(8, false, 4)},
          {"two components and an unused vertex", two}};
}

constexpr std::array all_weights{LoopWeights::loop, LoopWeights::warren};
constexpr std::array all_corners{CornerRule::smooth, CornerRule::sharp};

TEST(TriangleRefinement, RefinesInClosedFormAsBySorting) {
  for (const Named& named : sample_meshes()) {
    SCOPED_TRACE(named.name);
    const Connectivity parent = triangle_connectivity(named.mesh.faces, named.mesh.positions.size());
    const Connectivity middle = refine_triangles(parent), child = refine_triangles(middle);
    const FaceList faces = refined_triangles(middle);
    EXPECT_EQ(child.corners, faces.corners);
    const Connectivity sorted = triangle_connectivity(faces, child.vertex_count);
    EXPECT_EQ(child.opposite, sorted.opposite);
    EXPECT_EQ(child.face_count, sorted.face_count);
    ASSERT_EQ(child.edge_count(), sorted.edge_count());
    for (Index h = 0; h < child.corners.size(); ++h) {
      const Index o = child.opposite[h];
      ASSERT_TRUE(child.edge_start[child.edge[h]] == h || child.edge_start[child.edge[h]] == o);
      if (o != no_index) {
        ASSERT_EQ(child.edge[h], child.edge[o]);
      }
    }
    for (Index v = 0; v < child.vertex_count; ++v) {
      ASSERT_EQ(child.unused(v), sorted.unused(v));
      if (child.unused(v)) continue;
      ASSERT_EQ(child.source(child.vertex_start[v]), v);
      ASSERT_EQ(child.on_boundary(v), sorted.on_boundary(v));
      std::size_t neighbors = 0;
      child.for_each_neighbor(v, [&](Index) { ++neighbors; });
      ASSERT_EQ(neighbors, child.face_count[v] + (child.on_boundary(v) ? 1 : 0));
    }
    // Refinement changes neither the Euler number nor the number of components and loops.
    const Topology before = topology(named.mesh.faces, named.mesh.positions.size());
    const Topology after = topology(faces, child.vertex_count);
    EXPECT_EQ(after.euler, before.euler);
    EXPECT_EQ(after.components, before.components);
    EXPECT_EQ(after.boundary_loops, before.boundary_loops);
    EXPECT_EQ(after.boundary_edges, 4 * before.boundary_edges);
    EXPECT_EQ(after.unused_vertices, before.unused_vertices);
  }
}

TEST(TriangleRefinement, RefusesWhatIsNoOrientedManifold) {
  FaceList quad;
  quad.add(std::array<Index, 4>{0, 1, 2, 3});
  EXPECT_THROW(triangle_connectivity(quad, 4), InvariantError);
  FaceList three_on_an_edge;
  for (Index v : {2, 3, 4}) three_on_an_edge.add(0, 1, v);
  EXPECT_THROW(triangle_connectivity(three_on_an_edge, 5), InvariantError);
  FaceList turned;
  turned.add(0, 1, 2);
  turned.add(0, 1, 3);
  EXPECT_THROW(triangle_connectivity(turned, 4), InvariantError);
  FaceList bow_tie;
  bow_tie.add(0, 1, 2);
  bow_tie.add(0, 3, 4);
  EXPECT_THROW(triangle_connectivity(bow_tie, 5), InvariantError);
  FaceList beyond;
  beyond.add(0, 1, 7);
  EXPECT_THROW(triangle_connectivity(beyond, 3), InvariantError);
}

TEST(LoopBeta, IsTheFormulaOfLoopAndWarren) {
  EXPECT_DOUBLE_EQ(loop_beta(LoopWeights::loop, 3), 3.0 / 16);
  EXPECT_DOUBLE_EQ(loop_beta(LoopWeights::loop, 6), 1.0 / 16);
  EXPECT_DOUBLE_EQ(loop_beta(LoopWeights::warren, 3), 3.0 / 16);
  EXPECT_DOUBLE_EQ(loop_beta(LoopWeights::warren, 4), 3.0 / 32);
  EXPECT_DOUBLE_EQ(loop_beta(LoopWeights::warren, 6), 1.0 / 16);
}

TEST(LoopStencils, AreConvexCombinations) {
  for (const Named& named : sample_meshes())
    for (const LoopWeights weights : all_weights)
      for (const CornerRule corners : all_corners) {
        SCOPED_TRACE(named.name);
        const std::size_t n = named.mesh.positions.size();
        const Refinement step = loop_refine(named.mesh.faces, n, weights, corners);
        ASSERT_EQ(step.stencils.columns, n);
        ASSERT_EQ(step.faces.size(), 4 * named.mesh.faces.size());
        for (std::size_t r = 0; r < step.stencils.rows(); ++r) {
          double sum = 0;
          for (const double w : step.stencils.row(r).weights) {
            ASSERT_GT(w, 0);
            sum += w;
          }
          ASSERT_NEAR(sum, 1, 1e-15);
          for (const Index i : step.stencils.row(r).indices) ASSERT_LT(i, n);
        }
      }
}

TEST(LoopStencils, KeepSharpCornersAndUnusedVertices) {
  const Mesh patch = grid(3, 3);
  const std::size_t n = patch.positions.size();
  const Connectivity topology = triangle_connectivity(patch.faces, n);
  const StencilTable sharp = loop_refine(patch.faces, n, LoopWeights::loop, CornerRule::sharp).stencils;
  const StencilTable smooth = loop_refine(patch.faces, n, LoopWeights::loop, CornerRule::smooth).stencils;
  std::size_t corners = 0;
  for (Index v = 0; v < n; ++v) {
    const bool corner = topology.face_count[v] == 1;
    corners += corner ? 1 : 0;
    const Vec3 kept = apply_row<Vec3>(sharp.row(v), patch.positions),
               moved = apply_row<Vec3>(smooth.row(v), patch.positions);
    if (corner) {
      EXPECT_EQ(kept, patch.positions[v]);
      EXPECT_GT((moved - patch.positions[v]).norm(), 0.1);
    } else {
      EXPECT_EQ(kept, moved);
    }
  }
  EXPECT_EQ(corners, 2u);

  Mesh loose = patch;
  loose.positions.emplace_back(7, 8, 9);
  const Refinement step = loop_refine(loose.faces, n + 1);
  EXPECT_EQ(apply_row<Vec3>(step.stencils.row(n), loose.positions), Vec3(7, 8, 9));
}

TEST(Stencils, TransposeIsTheAdjoint) {
  const Mesh mesh = with_holes(irregular_sphere(6), 11);
  const LimitSurface surface(mesh.faces, mesh.positions.size(), 2);
  Random random(1);
  std::vector<double> x(surface.control_count()), y(surface.sample_count());
  for (double& value : x) value = random.uniform(-1, 1);
  for (double& value : y) value = random.uniform(-1, 1);
  const std::vector<double> sx = surface.to_samples<double>(x), sty = surface.to_control<double>(y);
  const double left = std::inner_product(sx.begin(), sx.end(), y.begin(), 0.0);
  const double right = std::inner_product(x.begin(), x.end(), sty.begin(), 0.0);
  EXPECT_NEAR(left, right, 1e-12);
  // Mass is conserved, because rows sum to one.
  EXPECT_NEAR(std::accumulate(sty.begin(), sty.end(), 0.0), std::accumulate(y.begin(), y.end(), 0.0), 1e-12);
  // A vector goes through as its components do.
  std::vector<Vec3> vectors;
  for (const double value : y) vectors.emplace_back(value, 2 * value, -value);
  const std::vector<Vec3> pulled = surface.to_control<Vec3>(vectors);
  for (std::size_t i = 0; i < pulled.size(); ++i) EXPECT_EQ(pulled[i], Vec3(sty[i], 2 * sty[i], -sty[i]));
}

// --- OpenMesh's subdivider as a second implementation.

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Oracle = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

std::vector<Vec3> openmesh_loop(const Mesh& mesh, int levels) {
  Oracle oracle;
  for (const Vec3& p : mesh.positions) oracle.add_vertex({p.x(), p.y(), p.z()});
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    oracle.add_face(oracle.vertex_handle(face[0]), oracle.vertex_handle(face[1]), oracle.vertex_handle(face[2]));
  }
  OpenMesh::Subdivider::Uniform::LoopT<Oracle, double> loop;
  loop.attach(oracle);
  loop(static_cast<std::size_t>(levels));
  loop.detach();
  std::vector<Vec3> positions;
  for (const auto v : oracle.vertices()) {
    const auto& p = oracle.point(v);
    positions.emplace_back(p[0], p[1], p[2]);
  }
  return positions;
}

TEST(LoopStencils, AgreeWithOpenMesh) {
  const std::vector<Named> meshes = {{"tetrahedron", tetrahedron()},
                                     {"irregular sphere", irregular_sphere(1)},
                                     {"sphere with holes", with_holes(irregular_sphere(2), 7)},
                                     {"torus", torus(7, 5)},
                                     {"grid", grid(4, 3)}};
  for (const Named& named : meshes) {
    SCOPED_TRACE(named.name);
    const CovMesh control = with_equal_covariances(named.mesh, Random(9).covariance(0.1, 1));
    const Mesh ours = subdivide(control, {.levels = 2, .limit = false});
    const std::vector<Vec3> theirs = openmesh_loop(named.mesh, 2);
    ASSERT_EQ(theirs.size(), ours.positions.size());
    for (std::size_t v = 0; v < named.mesh.positions.size(); ++v)
      EXPECT_LT((ours.positions[v] - theirs[v]).norm(), 1e-12);
    // New vertices are numbered differently: match each to the nearest one.
    const Neighbors index(theirs);
    std::vector<bool> hit(theirs.size(), false);
    std::vector<Neighbor> nearest;
    for (const Vec3& p : ours.positions) {
      index.nearest(p, 1, nearest);
      EXPECT_LT(nearest[0].distance, 1e-12);
      hit[nearest[0].index] = true;
    }
    EXPECT_EQ(std::count(hit.begin(), hit.end(), false), 0);
  }
}

}  // namespace
}  // namespace gpsrecon::test
