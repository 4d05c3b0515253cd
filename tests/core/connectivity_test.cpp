// Connectivity of random polygon soups, manifold or not, against the definitions: every pair of corners is looked at.

#include <gmock/gmock.h>
#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "support/random.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

using testing::HasSubstr;

enum class Soup { triangles, quads, polygons };

/// Few vertices, so that edges of three faces, neighbours that disagree and touching fans are common. Faces repeat no
/// vertex.
FaceList random_soup(Soup kind, std::size_t faces, std::size_t vertices, Random& random) {
  FaceList list;
  for (std::size_t f = 0; f < faces; ++f) {
    const std::size_t size = kind == Soup::triangles ? 3 : kind == Soup::quads ? 4 : 3 + random.below(4);
    std::vector<Index> face;
    while (face.size() < size) {
      const auto v = static_cast<Index>(random.below(vertices));
      if (std::find(face.begin(), face.end(), v) == face.end()) face.push_back(v);
    }
    list.add(face);
  }
  return list;
}

/// A closed grid of quadrilaterals with faces left out and turned: large manifold parts, and a few faults.
FaceList torn_torus(Index n, Random& random) {
  FaceList list;
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) {
      const auto at = [n](Index u, Index v) { return (u % n) * n + v % n; };
      std::array<Index, 4> face{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
      if (random.uniform() < 0.1) continue;
      if (random.uniform() < 0.03) std::reverse(face.begin(), face.end());
      list.add(face);
    }
  return list;
}

/// The definitions, by comparing all with all.
struct BruteForce {
  const FaceList& faces;
  std::vector<Index> face, next, previous, first, opposite;

  explicit BruteForce(const FaceList& list) : faces(list) {
    for (Index f = 0; f < list.size(); ++f)
      for (Index k = 0; k < list[f].size(); ++k) {
        const auto n = static_cast<Index>(list[f].size());
        face.push_back(f);
        next.push_back(list.offsets[f] + (k + 1) % n);
        previous.push_back(list.offsets[f] + (k + n - 1) % n);
      }
    for (Index h = 0; h < face.size(); ++h) {
      const std::vector<Index> same = between_same_ends(h);
      first.push_back(same.front());
      opposite.push_back(same.size() == 2 && source(same[0]) != source(same[1]) ? same[same[0] == h ? 1 : 0]
                                                                                : no_index);
    }
  }
  std::size_t size() const { return face.size(); }
  Index source(Index h) const { return faces.corners[h]; }
  Index target(Index h) const { return faces.corners[next[h]]; }
  std::vector<Index> between_same_ends(Index h) const {
    std::vector<Index> same;
    for (Index g = 0; g < size(); ++g)
      if (std::minmax({source(g), target(g)}) == std::minmax({source(h), target(h)})) same.push_back(g);
    return same;
  }
  /// Classes of 0 .. n - 1 under a relation: per element the smallest of its class.
  template <class Related>
  static std::vector<Index> classes(std::size_t n, const Related& related) {
    std::vector<Index> least(n);
    for (Index i = 0; i < n; ++i) least[i] = i;
    for (bool changed = true; changed;) {
      changed = false;
      for (Index i = 0; i < n; ++i)
        for (Index j = 0; j < n; ++j)
          if (related(i, j) && least[j] < least[i]) least[i] = least[j], changed = true;
    }
    return least;
  }
};

class OfSoups : public testing::TestWithParam<Soup> {
 protected:
  template <class Check>
  void for_each_soup(const Check& check) {
    Random random(7 + static_cast<std::uint64_t>(GetParam()));
    for (const auto& [faces, vertices] :
         std::vector<std::array<std::size_t, 2>>{{0, 4}, {1, 7}, {4, 7}, {9, 9}, {20, 12}, {12, 40}, {40, 30}})
      for (int k = 0; k < 12; ++k) {
        const FaceList list = random_soup(GetParam(), faces, vertices, random);
        check(list, vertices);
      }
    for (int k = 0; k < 4; ++k) check(torn_torus(7, random), 49);
  }
};
INSTANTIATE_TEST_SUITE_P(Kinds, OfSoups, testing::Values(Soup::triangles, Soup::quads, Soup::polygons));

TEST_P(OfSoups, HalfEdgesAndEdgesAreTheDefinitions) {
  for_each_soup([](const FaceList& faces, std::size_t vertices) {
    const Connectivity c = build_connectivity(faces, vertices);
    const BruteForce truth(faces);
    ASSERT_EQ(c.half_edge_count(), truth.size());
    ASSERT_EQ(c.face_total(), faces.size());
    std::set<Index> edges;
    std::size_t nonmanifold = 0, inconsistent = 0;
    const auto ends = [&](Index h) { return std::minmax({c.source(h), c.target(h)}); };
    std::vector<Index> bad_many, bad_same;
    for (Index h = 0; h < truth.size(); ++h) {
      ASSERT_EQ(c.face(h), truth.face[h]);
      ASSERT_EQ(c.next(h), truth.next[h]);
      ASSERT_EQ(c.previous(h), truth.previous[h]);
      ASSERT_EQ(c.source(h), truth.source(h));
      ASSERT_EQ(c.target(h), truth.target(h));
      ASSERT_EQ(c.opposite[h], truth.opposite[h]);
      ASSERT_EQ(c.edge_start[c.edge[h]], truth.first[h]);
      if (truth.first[h] != h) continue;
      // Numbered in the order of their first half-edges.
      ASSERT_EQ(c.edge[h], edges.size());
      edges.insert(h);
      const std::size_t halves = truth.between_same_ends(h).size();
      nonmanifold += halves > 2 ? 1 : 0;
      inconsistent += halves == 2 && truth.opposite[h] == no_index ? 1 : 0;
      if (halves > 2) bad_many.push_back(h);
      if (halves == 2 && truth.opposite[h] == no_index) bad_same.push_back(h);
    }
    ASSERT_EQ(c.edge_count(), edges.size());
    ASSERT_EQ(c.nonmanifold_edges, nonmanifold);
    ASSERT_EQ(c.inconsistent_edges, inconsistent);
    const auto first_of = [&](const std::vector<Index>& bad) {
      const auto before = [&](Index a, Index b) { return ends(a) < ends(b); };
      return bad.empty() ? no_index : *std::min_element(bad.begin(), bad.end(), before);
    };
    ASSERT_EQ(c.first_nonmanifold, first_of(bad_many));
    ASSERT_EQ(c.first_inconsistent, first_of(bad_same));
    for (Index f = 0; f < faces.size(); ++f) {
      ASSERT_EQ(c.face_start(f), faces.offsets[f]);
      ASSERT_EQ(c.face_size(f), faces[f].size());
    }
  });
}

TEST_P(OfSoups, VerticesKnowTheirFacesAndEdges) {
  for_each_soup([](const FaceList& faces, std::size_t vertices) {
    const Connectivity c = build_connectivity(faces, vertices);
    const VertexEdges at = vertex_edges(c);
    ASSERT_EQ(at.edges.size(), 2 * c.edge_count());
    for (Index v = 0; v < vertices; ++v) {
      const auto around = std::count(faces.corners.begin(), faces.corners.end(), v);
      ASSERT_EQ(c.face_count[v], around);
      ASSERT_EQ(c.unused(v), around == 0);
      std::vector<Index> edges;
      for (Index e = 0; e < c.edge_count(); ++e)
        if (c.source(c.edge_start[e]) == v || c.target(c.edge_start[e]) == v) edges.push_back(e);
      ASSERT_TRUE(std::equal(at[v].begin(), at[v].end(), edges.begin(), edges.end()));
      if (c.unused(v)) continue;
      ASSERT_EQ(c.source(c.vertex_start[v]), v);
      bool open = false;
      for (Index h = 0; h < c.half_edge_count(); ++h) open = open || (c.source(h) == v && c.opposite[h] == no_index);
      ASSERT_EQ(c.on_boundary(v), open);
    }
  });
}

TEST_P(OfSoups, FansAreCornersJoinedAcrossEdges) {
  for_each_soup([](const FaceList& faces, std::size_t vertices) {
    const Connectivity c = build_connectivity(faces, vertices);
    const BruteForce truth(faces);
    // Corners g and h of a vertex are next to each other if the edge that leaves one arrives beside the other.
    const std::vector<Index> fan = BruteForce::classes(truth.size(), [&](Index g, Index h) {
      return truth.opposite[g] == truth.previous[h] || truth.opposite[h] == truth.previous[g];
    });
    std::vector<Index> count(vertices, 0);
    for (Index h = 0; h < fan.size(); ++h) count[c.source(h)] += fan[h] == h ? 1 : 0;
    ASSERT_EQ(vertex_fans(c), count);
    // A walk sees the whole of a closed fan, and of an open one what lies counter-clockwise of its start.
    for (Index h = 0; h < fan.size(); ++h) {
      std::vector<Index> seen;
      const Index last = c.for_each_in_fan(h, [&](Index g) { seen.push_back(g); });
      ASSERT_EQ(seen.front(), h);
      for (std::size_t k = 0; k < seen.size(); ++k) {
        ASSERT_EQ(c.source(seen[k]), c.source(h));
        ASSERT_EQ(fan[seen[k]], fan[h]);
        if (k > 0) {
          ASSERT_EQ(c.opposite[seen[k]], c.previous(seen[k - 1]));
        }
      }
      const auto members = std::count(fan.begin(), fan.end(), fan[h]);
      if (last == no_index || c.opposite[h] == no_index) {
        ASSERT_EQ(seen.size(), members);
      }
      if (last != no_index) {
        ASSERT_EQ(c.target(last), c.source(h));
        ASSERT_EQ(c.opposite[last], no_index);
      }
    }
  });
}

TEST_P(OfSoups, ComponentsAreFacesJoinedAcrossEdges) {
  for_each_soup([](const FaceList& faces, std::size_t vertices) {
    const BruteForce truth(faces);
    const std::vector<Index> least = BruteForce::classes(faces.size(), [&](Index f, Index g) {
      for (Index h = faces.offsets[f]; h < faces.offsets[f + 1]; ++h)
        if (truth.opposite[h] != no_index && truth.face[truth.opposite[h]] == g) return true;
      return false;
    });
    const Components components = face_components(build_connectivity(faces, vertices));
    std::map<Index, Index> label;
    for (Index f = 0; f < faces.size(); ++f) {
      label.try_emplace(least[f], static_cast<Index>(label.size()));
      ASSERT_EQ(components.of_face[f], label[least[f]]);
    }
    ASSERT_EQ(components.count, label.size());
  });
}

/// Each boundary half-edge is in one loop, and is followed by one of the same fan.
TEST_P(OfSoups, LoopsPassEveryBoundaryEdgeOnce) {
  for_each_soup([](const FaceList& faces, std::size_t vertices) {
    const Connectivity c = build_connectivity(faces, vertices);
    const BruteForce truth(faces);
    const std::vector<Index> fan = BruteForce::classes(truth.size(), [&](Index g, Index h) {
      return truth.opposite[g] == truth.previous[h] || truth.opposite[h] == truth.previous[g];
    });
    std::vector<std::vector<Index>> loops;
    std::set<Index> left;
    for (Index h = 0; h < truth.size(); ++h)
      if (truth.opposite[h] == no_index) left.insert(h);
    while (!left.empty()) {
      std::vector<Index> loop;
      for (Index h = *left.begin(); left.erase(h) > 0;) {
        loop.push_back(truth.source(h));
        for (Index g = 0; g < truth.size(); ++g)
          if (truth.opposite[g] == no_index && fan[g] == fan[truth.next[h]]) {
            h = g;
            break;
          }
      }
      loops.push_back(loop);
    }
    ASSERT_EQ(boundary_loops(c), loops);
  });
}

TEST_P(OfSoups, CountsAreThoseOfTheParts) {
  for_each_soup([](const FaceList& faces, std::size_t vertices) {
    const Connectivity c = build_connectivity(faces, vertices);
    const Topology t = topology(faces, vertices);
    const std::set<Index> used(faces.corners.begin(), faces.corners.end());
    EXPECT_EQ(t.vertices, used.size());
    EXPECT_EQ(t.unused_vertices, vertices - used.size());
    EXPECT_EQ(t.euler,
              static_cast<long>(used.size()) - static_cast<long>(c.edge_count()) + static_cast<long>(faces.size()));
    EXPECT_EQ(t.manifold(), manifold_faults(c).empty());
    if (t.manifold())
      EXPECT_NO_THROW(manifold_connectivity(faces, vertices));
    else
      EXPECT_THROW(manifold_connectivity(faces, vertices), InvariantError);
  });
}

TEST(Connectivity, NamesTheFirstFault) {
  FaceList faces;
  for (const Index v : {6U, 7U, 8U}) faces.add(5, 4, v);
  for (const Index v : {2U, 3U}) faces.add(0, 1, v);
  try {
    manifold_connectivity(faces, 9, "mesh of a test");
    FAIL();
  } catch (const InvariantError& error) {
    EXPECT_THAT(error.what(), HasSubstr("mesh of a test: 1 edges of more than two faces (first: 5-4 of face 0)"));
    EXPECT_THAT(error.what(), HasSubstr("1 edges whose faces face opposite sides (first: 0-1 of face 3)"));
  }
  EXPECT_THROW(build_connectivity(faces, 8), InvariantError);
}

}  // namespace
}  // namespace gpsrecon::test
