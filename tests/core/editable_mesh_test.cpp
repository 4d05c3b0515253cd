// Meshes to half-edges and back, what is refused, and edits that keep a manifold one.

#include <gmock/gmock.h>
#include <gpsrecon/core/editable_mesh.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/repair_topology.h>
#include <gtest/gtest.h>

#include <CGAL/boost/graph/Euler_operations.h>

#include <algorithm>
#include <array>

#include "support/random.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using Vertex = EditableMesh::Vertex_index;

FaceList triangles(const std::vector<std::array<Index, 3>>& list) {
  FaceList faces;
  for (const auto& t : list) faces.add(t);
  return faces;
}

/// A torus of n × n quadrilaterals, each of them two triangles if asked, each of which is left out with some chance.
FaceList torus(Index n, bool triangulated, double share_left_out, Random& random) {
  const auto at = [n](Index u, Index v) { return (u % n) * n + v % n; };
  FaceList faces;
  const auto add = [&](const std::vector<Index>& face) {
    if (random.uniform() >= share_left_out) faces.add(face);
  };
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) {
      const Index a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      if (triangulated)
        add({a, b, c}), add({a, c, d});
      else
        add({a, b, c, d});
    }
  return faces;
}

FaceList faces_of(const EditableMesh& mesh) {
  return face_list(mesh, [](Vertex v) { return static_cast<Index>(v); });
}

void expect_round_trip(const FaceList& faces, std::size_t vertex_count, Random& random) {
  const std::vector<Vec3> positions = random.vectors(vertex_count);
  const EditableMesh mesh = editable_mesh(positions, faces);
  EXPECT_EQ(faces_of(mesh), faces);
  ASSERT_EQ(mesh.number_of_vertices(), vertex_count);
  for (const Vertex v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    EXPECT_EQ(Vec3(p.x(), p.y(), p.z()), positions[v]);
  }
  EXPECT_TRUE(mesh.is_valid());
  EXPECT_EQ(mesh.number_of_edges(), build_connectivity(faces, vertex_count).edge_count());
}

TEST(EditableMesh, GivesTheFacesBack) {
  Random random(3);
  expect_round_trip({}, 0, random);
  expect_round_trip({}, 3, random);
  expect_round_trip(triangles({{4, 2, 1}}), 6, random);
  // Random polygons made manifold: boundaries, several components, vertices that no face uses.
  for (const std::size_t count : {2U, 6U, 20U, 60U})
    for (int k = 0; k < 10; ++k) {
      FaceList soup;
      for (std::size_t f = 0; f < count; ++f) {
        std::vector<Index> face;
        for (const std::size_t size = 3 + random.below(3); face.size() < size;) {
          const auto v = static_cast<Index>(random.below(9));
          if (std::find(face.begin(), face.end(), v) == face.end()) face.push_back(v);
        }
        soup.add(face);
      }
      const TopologyRepair repair = repair_topology(soup, 9);
      expect_round_trip(repair.faces, repair.origin.size(), random);
    }
  for (const bool triangulated : {false, true})
    for (const double share : {0.0, 0.1, 0.5}) {
      const TopologyRepair repair = repair_topology(torus(9, triangulated, share, random), 81);
      expect_round_trip(repair.faces, repair.origin.size(), random);
    }
}

TEST(EditableMesh, RefusesWhatIsNotManifold) {
  Random random(4);
  const std::vector<Vec3> positions = random.vectors(9);
  const auto refusal = [&](const std::vector<std::array<Index, 3>>& list, const char* text) {
    EXPECT_FALSE(manifold_faults(build_connectivity(triangles(list), 9)).empty());
    EXPECT_THAT([&] { editable_mesh(positions, triangles(list)); }, ThrowsMessage<InvariantError>(HasSubstr(text)));
  };
  refusal({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, "face 2 ");             // three at an edge
  refusal({{0, 1, 2}, {0, 1, 3}}, "face 1 ");                        // two sides
  refusal({{0, 1, 2}, {0, 3, 4}}, "vertex 0");                       // two open fans
  refusal({{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 4, 5}}, "face 3 ");  // a closed one and an open one
  refusal({{0, 4, 5}, {0, 1, 2}, {0, 2, 3}, {0, 3, 1}}, "face 3 ");  // in the other order
}

TEST(EditableMesh, RefusesASoupJustIfItIsNotManifold) {
  Random random(5);
  int manifold = 0, refused = 0;
  for (int k = 0; k < 2000; ++k) {
    FaceList soup;
    for (std::size_t f = 1 + random.below(5); f > 0; --f) {
      std::array<Index, 3> face{};
      do
        for (Index& v : face) v = static_cast<Index>(random.below(8));
      while (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]);
      soup.add(face);
    }
    const bool faulty = !manifold_faults(build_connectivity(soup, 8)).empty();
    bool thrown = false;
    try {
      editable_mesh(std::vector<Vec3>(8, Vec3::Zero()), soup);
    } catch (const InvariantError&) {
      thrown = true;
    }
    ASSERT_EQ(thrown, faulty) << k;
    ++(faulty ? refused : manifold);
  }
  EXPECT_GT(manifold, 100);
  EXPECT_GT(refused, 100);
}

/// Its vertices, edges and faces, once numbered from 0, are manifold and as many as the Euler number says.
void expect_manifold(const EditableMesh& mesh, long euler, std::size_t loops) {
  ASSERT_TRUE(mesh.is_valid());
  const FaceList faces = faces_of(mesh);
  const Topology t = topology(faces, mesh.number_of_vertices() + mesh.number_of_removed_vertices());
  EXPECT_TRUE(t.manifold());
  EXPECT_EQ(t.euler, euler);
  EXPECT_EQ(t.boundary_loops, loops);
}

TEST(EditableMesh, StaysManifoldUnderFlipsAndCollapses) {
  Random random(6);
  for (const double share : {0.0, 0.05}) {
    const TopologyRepair repair = repair_topology(torus(14, true, share, random), 196);
    const Topology before = topology(repair.faces, repair.origin.size());
    EditableMesh mesh = editable_mesh(random.vectors(repair.origin.size()), repair.faces);
    std::size_t flips = 0, collapses = 0;
    for (int k = 0; k < 3000; ++k) {
      const auto edges = mesh.number_of_edges() + mesh.number_of_removed_edges();
      const EditableMesh::Edge_index e(static_cast<Index>(random.below(edges)));
      if (mesh.is_removed(e)) continue;
      const auto h = mesh.halfedge(e);
      if (k % 8 == 0) {
        if (mesh.is_border(e) || !CGAL::Euler::does_satisfy_link_condition(e, mesh)) continue;
        CGAL::Euler::collapse_edge(e, mesh);
        ++collapses;
      } else if (!mesh.is_border(e)) {
        const Vertex c = mesh.target(mesh.next(h)), d = mesh.target(mesh.next(mesh.opposite(h)));
        if (c == d || mesh.halfedge(c, d) != EditableMesh::null_halfedge()) continue;
        CGAL::Euler::flip_edge(h, mesh);
        ++flips;
      }
    }
    EXPECT_GT(flips, 100U);
    EXPECT_GT(collapses, 50U);
    expect_manifold(mesh, before.euler, before.boundary_loops);
  }
}

}  // namespace
}  // namespace gpsrecon::test
