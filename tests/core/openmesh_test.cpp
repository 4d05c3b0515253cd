// Connectivity of manifold meshes against that of OpenMesh.

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/repair_topology.h>
#include <gtest/gtest.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>

#include "support/random.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;
using Peer = OpenMesh::PolyMesh_ArrayKernelT<>;

/// Random polygons over few vertices, made manifold: pieces of every shape, with fans that were parted.
FaceList random_manifold(std::size_t faces, std::size_t vertices, Random& random, std::size_t& vertex_count) {
  FaceList soup;
  for (std::size_t f = 0; f < faces; ++f) {
    const std::size_t size = 3 + random.below(3);
    std::vector<Index> face;
    while (face.size() < size) {
      const auto v = static_cast<Index>(random.below(vertices));
      if (std::find(face.begin(), face.end(), v) == face.end()) face.push_back(v);
    }
    soup.add(face);
  }
  const TopologyRepair repair = repair_topology(soup, vertices);
  vertex_count = repair.origin.size();
  return repair.faces;
}

/// A closed grid, with some faces left out.
FaceList torn_torus(Index n, double share, Random& random) {
  FaceList list;
  const auto at = [n](Index u, Index v) { return (u % n) * n + v % n; };
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j)
      if (random.uniform() >= share)
        list.add(std::vector<Index>{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  return list;
}

void expect_as_openmesh(const FaceList& faces, std::size_t vertex_count) {
  const Connectivity c = manifold_connectivity(faces, vertex_count);
  Peer peer;
  for (std::size_t v = 0; v < vertex_count; ++v) peer.add_vertex({0, 0, 0});
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::vector<VertexHandle> corners;
    for (const Index v : faces[f]) corners.emplace_back(static_cast<int>(v));
    ASSERT_TRUE(peer.add_face(corners).is_valid());
  }
  ASSERT_EQ(peer.n_edges(), c.edge_count());
  for (Index h = 0; h < c.half_edge_count(); ++h) {
    const HalfedgeHandle half =
        peer.find_halfedge(VertexHandle(static_cast<int>(c.source(h))), VertexHandle(static_cast<int>(c.target(h))));
    ASSERT_TRUE(half.is_valid());
    ASSERT_EQ(peer.face_handle(half).idx(), static_cast<int>(c.face(h)));
    ASSERT_EQ(peer.to_vertex_handle(peer.next_halfedge_handle(half)).idx(), static_cast<int>(c.target(c.next(h))));
    const FaceHandle across = peer.opposite_face_handle(half);
    ASSERT_EQ(across.is_valid(), c.opposite[h] != no_index);
    if (across.is_valid()) {
      ASSERT_EQ(across.idx(), static_cast<int>(c.face(c.opposite[h])));
    }
  }
  for (Index v = 0; v < vertex_count; ++v) {
    const VertexHandle vertex(static_cast<int>(v));
    ASSERT_EQ(peer.is_isolated(vertex), c.unused(v));
    if (c.unused(v)) continue;
    ASSERT_EQ(peer.is_boundary(vertex), c.on_boundary(v));
    // OpenMesh turns clockwise; both begin somewhere, on the boundary at an end of it.
    std::vector<int> theirs, ours;
    for (const VertexHandle neighbor : peer.vv_range(vertex)) theirs.push_back(neighbor.idx());
    c.for_each_neighbor(v, [&](Index neighbor) { ours.push_back(static_cast<int>(neighbor)); });
    std::reverse(theirs.begin(), theirs.end());
    ASSERT_TRUE(std::is_permutation(ours.begin(), ours.end(), theirs.begin(), theirs.end()));
    std::rotate(theirs.begin(), std::find(theirs.begin(), theirs.end(), ours.front()), theirs.end());
    ASSERT_EQ(ours, theirs);
  }
  // Loops of half-edges without a face.
  std::size_t loops = 0;
  std::vector<char> seen(peer.n_halfedges(), 0);
  for (const HalfedgeHandle start : peer.halfedges()) {
    if (!peer.is_boundary(start) || seen[static_cast<std::size_t>(start.idx())]) continue;
    ++loops;
    for (HalfedgeHandle h = start; !seen[static_cast<std::size_t>(h.idx())]; h = peer.next_halfedge_handle(h))
      seen[static_cast<std::size_t>(h.idx())] = 1;
  }
  EXPECT_EQ(boundary_loops(c).size(), loops);
}

TEST(Connectivity, IsThatOfOpenMesh) {
  Random random(5);
  for (const std::size_t faces : {1U, 5U, 20U, 60U})
    for (int k = 0; k < 10; ++k) {
      std::size_t vertices = 0;
      const FaceList manifold = random_manifold(faces, 9, random, vertices);
      expect_as_openmesh(manifold, vertices);
    }
  for (const double share : {0.0, 0.02, 0.3})
    for (int k = 0; k < 5; ++k) {
      const TopologyRepair repair = repair_topology(torn_torus(12, share, random), 144);
      expect_as_openmesh(repair.faces, repair.origin.size());
    }
}

}  // namespace
}  // namespace gpsrecon::test
