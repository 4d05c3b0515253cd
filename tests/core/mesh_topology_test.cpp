// Loops, components, fans and counts on meshes whose topology is known.

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "support/meshes.h"

namespace gpsrecon::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A cyclic or open grid of quads: nu × nv of them.
FaceList quads(Index nu, Index nv, bool cyclic_u, bool cyclic_v) {
  const Index rows = cyclic_v ? nv : nv + 1, columns = cyclic_u ? nu : nu + 1;
  const auto at = [&](Index u, Index v) { return (v % rows) * columns + u % columns; };
  FaceList faces;
  for (Index v = 0; v < nv; ++v)
    for (Index u = 0; u < nu; ++u)
      faces.add(std::array<Index, 4>{at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)});
  return faces;
}

TEST(Topology, OfATetrahedron) {
  const Topology t = topology(tetrahedron().faces, 4);
  EXPECT_TRUE(t.manifold());
  EXPECT_EQ(t.vertices, 4u);
  EXPECT_EQ(t.edges, 6u);
  EXPECT_EQ(t.faces, 4u);
  EXPECT_EQ(t.euler, 2);
  EXPECT_EQ(t.components, 1u);
  EXPECT_EQ(t.boundary_loops, 0u);
  EXPECT_EQ(t.boundary_edges, 0u);
}

TEST(Topology, OfATorus) {
  const Topology t = topology(quads(6, 5, true, true), 30);
  EXPECT_TRUE(t.manifold());
  EXPECT_EQ(t.euler, 0);
  EXPECT_EQ(t.edges, 60u);
  EXPECT_EQ(t.boundary_loops, 0u);
  EXPECT_EQ(t.components, 1u);
}

TEST(Topology, OfADiscAndACylinder) {
  const Topology disc = topology(quads(4, 3, false, false), 20);
  EXPECT_TRUE(disc.manifold());
  EXPECT_EQ(disc.euler, 1);
  EXPECT_EQ(disc.boundary_loops, 1u);
  EXPECT_EQ(disc.boundary_edges, 14u);
  const Topology cylinder = topology(quads(6, 3, true, false), 24);
  EXPECT_TRUE(cylinder.manifold());
  EXPECT_EQ(cylinder.euler, 0);
  EXPECT_EQ(cylinder.boundary_loops, 2u);
  EXPECT_EQ(cylinder.boundary_edges, 12u);
}

TEST(Topology, CountsComponentsAndUnusedVertices) {
  FaceList faces = tetrahedron().faces;
  faces.add(7, 8, 9);
  const Topology t = topology(faces, 12);
  EXPECT_EQ(t.components, 2u);
  EXPECT_EQ(t.vertices, 7u);
  EXPECT_EQ(t.unused_vertices, 5u);
  EXPECT_EQ(t.euler, 3);
  EXPECT_EQ(topology(FaceList{}, 3).unused_vertices, 3u);
  EXPECT_TRUE(topology(FaceList{}, 0).manifold());
}

TEST(Topology, SeesABowTieVertex) {
  // Two triangles that share only vertex 0.
  const FaceList faces = faces_of({{0, 1, 2}, {0, 3, 4}});
  const Topology t = topology(faces, 5);
  EXPECT_FALSE(t.manifold());
  EXPECT_EQ(t.nonmanifold_vertices, 1u);
  EXPECT_EQ(t.nonmanifold_edges, 0u);
  EXPECT_EQ(t.components, 2u);  // joined across edges only
  EXPECT_EQ(t.boundary_loops, 2u);
  const Connectivity he = build_connectivity(faces, 5);
  EXPECT_THAT(vertex_fans(he), ElementsAre(2, 1, 1, 1, 1));
  EXPECT_THAT(boundary_loops(he), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(0, 3, 4)));
}

TEST(Topology, SeesABowTieOfClosedFans) {
  // Two tetrahedra with a common vertex.
  FaceList faces = tetrahedron().faces;
  for (const auto& t : std::vector<std::array<Index, 3>>{{0, 4, 5}, {0, 5, 6}, {0, 6, 4}, {4, 6, 5}})
    faces.add(t[0], t[1], t[2]);
  const Topology t = topology(faces, 7);
  EXPECT_EQ(t.nonmanifold_vertices, 1u);
  EXPECT_EQ(t.boundary_loops, 0u);
  EXPECT_EQ(t.components, 2u);
}

TEST(Topology, SeesANonManifoldEdge) {
  const Topology t = topology(faces_of({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), 5);
  EXPECT_FALSE(t.manifold());
  EXPECT_EQ(t.nonmanifold_edges, 1u);
  EXPECT_EQ(t.inconsistent_edges, 0u);
  EXPECT_EQ(t.edges, 7u);
  EXPECT_EQ(t.components, 3u);
}

TEST(Topology, SeesInconsistentOrientation) {
  const Topology t = topology(faces_of({{0, 1, 2}, {0, 1, 3}}), 4);
  EXPECT_FALSE(t.manifold());
  EXPECT_EQ(t.inconsistent_edges, 1u);
  EXPECT_EQ(t.nonmanifold_edges, 0u);
}

TEST(Topology, SeesThatAMoebiusStripCannotBeOriented) {
  // A strip of quads closed with a half twist: however its faces are turned, some edge is run through twice the same
  // way.
  constexpr Index n = 6;
  for (unsigned turned = 0; turned < (1u << n); ++turned) {
    FaceList faces;
    for (Index i = 0; i < n; ++i) {
      const bool last = i + 1 == n;
      std::array<Index, 4> face{2 * i, last ? 1 : 2 * i + 2, last ? 0 : 2 * i + 3, 2 * i + 1};
      if ((turned >> i & 1) != 0) std::reverse(face.begin(), face.end());
      faces.add(face);
    }
    const Topology t = topology(faces, 2 * n);
    ASSERT_GE(t.inconsistent_edges, 1u);
    ASSERT_EQ(t.inconsistent_edges % 2, 1u);
    ASSERT_EQ(t.nonmanifold_edges, 0u);
    ASSERT_EQ(t.euler, 0);
  }
}

TEST(Topology, RefusesIndicesOutOfRange) {
  EXPECT_THROW(topology(faces_of({{0, 1, 9}}), 3), InvariantError);
}

TEST(BoundaryLoops, RunWithTheSurfaceToTheirLeft) {
  const FaceList disc = quads(2, 2, false, false);
  EXPECT_THAT(boundary_loops(build_connectivity(disc, 9)), ElementsAre(ElementsAre(0, 1, 2, 5, 8, 7, 6, 3)));
  const FaceList closed = tetrahedron().faces;
  EXPECT_THAT(boundary_loops(build_connectivity(closed, 4)), IsEmpty());
}

TEST(BoundaryLoops, CoverEveryBoundaryEdgeOnce) {
  // A 5 × 5 grid with two square holes that touch at a vertex (14). A loop that stays in its fan there passes from the
  // edge of one hole to that of the other, so that the two make one loop.
  FaceList full = quads(5, 5, false, false), faces;
  for (std::size_t f = 0; f < full.size(); ++f)
    if (f != 6 && f != 12) faces.add(full[f]);
  const Connectivity he = build_connectivity(faces, 36);
  const auto loops = boundary_loops(he);
  ASSERT_EQ(loops.size(), 2u);
  EXPECT_EQ(loops[0].size(), 20u);
  EXPECT_EQ(loops[1].size(), 8u);
  EXPECT_EQ(std::count(loops[1].begin(), loops[1].end(), 14), 2);
  std::size_t length = 0;
  for (const auto& loop : loops) length += loop.size();
  EXPECT_EQ(length, topology(faces, 36).boundary_edges);
  EXPECT_EQ(topology(faces, 36).nonmanifold_vertices, 1u);
}

TEST(FaceComponents, AreNumberedInOrderOfAppearance) {
  const FaceList faces = faces_of({{0, 1, 2}, {3, 4, 5}, {2, 1, 6}, {5, 4, 7}, {8, 9, 10}});
  const Components c = face_components(build_connectivity(faces, 11));
  EXPECT_EQ(c.count, 3u);
  EXPECT_THAT(c.of_face, ElementsAre(0, 1, 0, 1, 2));
}

TEST(ValidateCovMesh, RequiresAnOrientedManifold) {
  CovMesh mesh;
  mesh.vertices.means.assign(5, Vec3::Zero());
  mesh.vertices.covariances.assign(5, Sym3::identity());
  mesh.vertices.weights.assign(5, 1);
  mesh.faces = tetrahedron().faces;
  EXPECT_NO_THROW(validate(mesh));
  for (const FaceList& bad :
       {faces_of({{0, 1, 2}, {0, 3, 4}}), faces_of({{0, 1, 2}, {0, 1, 3}}), faces_of({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}),
        faces_of({{0, 1, 5}}), faces_of({{0, 1, 1}})}) {
    mesh.faces = bad;
    EXPECT_THROW(validate(mesh), InvariantError);
  }
}

}  // namespace
}  // namespace gpsrecon::test
