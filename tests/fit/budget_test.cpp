#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/fit/fit.h>
#include <gpsrecon/fit/refine.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <gpsrecon/triangulate/triangulate.h>
#include <gtest/gtest.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

struct Control {
  CovMesh mesh = triangulate(test::tangent_discs(test::torus(610, 1, 0.4))).mesh;
  Connectivity topology = triangle_connectivity(mesh.faces, mesh.vertices.size());
  std::vector<double> evidence = std::vector<double>(topology.edge_count());

  explicit Control(std::uint64_t seed) {
    test::Random random(seed);
    for (double& e : evidence) e = std::max(0.0, random.uniform(-1, 1));
  }
};

std::size_t count(const std::vector<char>& marked) {
  return static_cast<std::size_t>(std::count(marked.begin(), marked.end(), 1));
}

TEST(StrongestEdges, AddExactlyTheVerticesTheyCount) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Control c(seed);
    for (const std::size_t most : {0u, 1u, 2u, 7u, 50u, 333u, 100000u}) {
      const std::vector<char> marked = strongest_edges(c.mesh, c.topology, c.evidence, most);
      EXPECT_LE(count(marked), most);
      const CovMesh fine = split_edges(c.mesh, c.topology, marked);
      EXPECT_EQ(fine.vertices.size(), c.mesh.vertices.size() + count(marked));
      EXPECT_TRUE(topology(fine.faces, fine.vertices.size()).manifold());
      if (most >= 7 && most <= 333) {
        EXPECT_GT(count(marked), most - 4);  // what was left over was too small for any edge
      }
    }
  }
}

TEST(StrongestEdges, AreAllWithoutALimit) {
  const Control c(4);
  std::vector<char> all(c.evidence.size());
  for (std::size_t e = 0; e < all.size(); ++e) all[e] = c.evidence[e] > 0 ? 1 : 0;
  const CovMesh a = split_edges(c.mesh, c.topology, all);
  const CovMesh b = split_edges(c.mesh, c.topology, strongest_edges(c.mesh, c.topology, c.evidence, no_index));
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.vertices.means, b.vertices.means);
}

TEST(StrongestEdges, BeginWithTheStrongest) {
  const Control c(5);
  const auto strongest = std::max_element(c.evidence.begin(), c.evidence.end()) - c.evidence.begin();
  std::vector<char> alone(c.evidence.size(), 0);
  alone[strongest] = 1;
  const std::size_t needed = split_edges(c.mesh, c.topology, alone).vertices.size() - c.mesh.vertices.size();
  EXPECT_TRUE(strongest_edges(c.mesh, c.topology, c.evidence, needed)[strongest]);
  // Without it, when it does not fit.
  if (needed > 1) {
    EXPECT_FALSE(strongest_edges(c.mesh, c.topology, c.evidence, needed - 1)[strongest]);
  }
}

TEST(FitLimit, HoldsExactlyAndIsUsedUp) {
  // A coarse torus: the points show much more than its control mesh can follow.
  const CovMesh coarse = triangulate(test::tangent_discs(test::torus(144, 1, 0.4))).mesh;
  const PointCloud cloud = test::torus(28657, 1, 0.4).cloud();
  const std::size_t n = coarse.vertices.size();
  const std::size_t free = fit(coarse, cloud).mesh.vertices.size();
  ASSERT_GT(free, n + 60);
  for (const std::size_t most : {n - 5, n, n + 1, n + 20, n + 60}) {
    const std::size_t vertices = fit(coarse, cloud, {.max_vertices = most}).mesh.vertices.size();
    EXPECT_LE(vertices, std::max(n, most));
    EXPECT_GE(vertices + 3, std::max(n, most));
  }
  EXPECT_EQ(fit(coarse, cloud, {.max_vertices = free}).mesh.vertices.size(), free);
}

}  // namespace
}  // namespace gpsrecon
