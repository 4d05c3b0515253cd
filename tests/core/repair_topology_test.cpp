#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/repair_topology.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/meshes.h"
#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::faces_of;

/// What a repair may never break: manifold faces, over copies of the corners they had.
void expect_sound(const FaceList& before, std::size_t n, const TopologyRepair& repair) {
  ASSERT_GE(repair.origin.size(), n);
  EXPECT_EQ(repair.origin.size() - n, repair.copies);
  for (Index v = 0; v < n; ++v) EXPECT_EQ(repair.origin[v], v);
  EXPECT_TRUE(topology(repair.faces, repair.origin.size()).manifold());
  EXPECT_EQ(repair.faces.size() + repair.dropped_faces, before.size());
  std::multiset<std::multiset<Index>> old;
  for (std::size_t f = 0; f < before.size(); ++f) old.emplace(before[f].begin(), before[f].end());
  for (std::size_t f = 0; f < repair.faces.size(); ++f) {
    std::multiset<Index> corners;
    for (const Index v : repair.faces[f]) corners.insert(repair.origin[v]);
    const auto match = old.find(corners);
    ASSERT_NE(match, old.end());
    old.erase(match);
  }
}

const FaceList tetrahedron = faces_of({{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});

TEST(RepairTopology, WhatIsManifoldStays) {
  const TopologyRepair repair = repair_topology(tetrahedron, 5);  // a vertex of no face, too
  EXPECT_FALSE(repair.changed());
  EXPECT_EQ(repair.faces, tetrahedron);
  EXPECT_EQ(repair.origin.size(), 5U);
}

TEST(RepairTopology, TurnsTheMinority) {
  FaceList mixed = faces_of({{0, 1, 2}, {0, 3, 2}, {0, 3, 1}, {1, 3, 2}});
  const TopologyRepair repair = repair_topology(mixed, 4);
  expect_sound(mixed, 4, repair);
  EXPECT_EQ(repair.turned_faces, 1U);
  EXPECT_EQ(repair.copies, 0U);
  EXPECT_EQ(topology(repair.faces, 4).euler, 2);
}

TEST(RepairTopology, PartsFansThatTouchInAVertex) {
  const FaceList bow = faces_of({{0, 1, 2}, {0, 3, 4}});
  const TopologyRepair repair = repair_topology(bow, 5);
  expect_sound(bow, 5, repair);
  EXPECT_EQ(repair.copies, 1U);
  EXPECT_EQ(repair.origin[5], 0U);
  EXPECT_EQ(topology(repair.faces, 6).components, 2U);
}

TEST(RepairTopology, CutsAnEdgeOfThreeFaces) {
  const FaceList book = faces_of({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
  const TopologyRepair repair = repair_topology(book, 5);
  expect_sound(book, 5, repair);
  EXPECT_EQ(repair.cut_edges, 1U);
  EXPECT_EQ(topology(repair.faces, repair.origin.size()).components, 3U);
  EXPECT_EQ(repair.copies, 4U);
}

TEST(RepairTopology, TearsAMoebiusStripOnce) {
  // Five quadrilaterals around, the last joined with a twist.
  const FaceList strip = faces_of({{0, 1, 3, 2}, {2, 3, 5, 4}, {4, 5, 7, 6}, {6, 7, 9, 8}, {8, 9, 0, 1}});
  const TopologyRepair repair = repair_topology(strip, 10);
  expect_sound(strip, 10, repair);
  EXPECT_EQ(repair.torn_edges, 1U);
  const Topology after = topology(repair.faces, repair.origin.size());
  EXPECT_EQ(after.components, 1U);
  EXPECT_EQ(after.boundary_loops, 1U);
  EXPECT_EQ(after.euler, 1);  // a plain strip now
}

TEST(RepairTopology, DropsFacesWithoutThreeCornersAndDoubles) {
  const FaceList bad = faces_of({{0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {1, 0, 2}, {3, 3, 3}});
  const TopologyRepair repair = repair_topology(bad, 4);
  expect_sound(bad, 4, repair);
  EXPECT_EQ(repair.faces.size(), 1U);
  EXPECT_EQ(repair.dropped_faces, 4U);
}

TEST(RepairTopology, AnySoupBecomesManifold) {
  test::Random random(77);
  for (int round = 0; round < 500; ++round) {
    FaceList soup;
    const int count = 1 + static_cast<int>(30 * random.uniform(0, 1));
    for (int f = 0; f < count; ++f) {
      std::vector<Index> face;
      const int corners = random.uniform(0, 1) < 0.7 ? 3 : 4;
      for (int k = 0; k < corners; ++k) face.push_back(static_cast<Index>(9 * random.uniform(0, 1)));
      soup.add(face);
    }
    const TopologyRepair repair = repair_topology(soup, 9);
    expect_sound(soup, 9, repair);
    if (HasFailure()) return;
    EXPECT_FALSE(repair_topology(repair.faces, repair.origin.size()).changed());
  }
}

TEST(RepairTopology, CornersOutOfRangeAreRefused) {
  EXPECT_THROW(repair_topology(tetrahedron, 3), InvariantError);
}

}  // namespace
}  // namespace gpsrecon
