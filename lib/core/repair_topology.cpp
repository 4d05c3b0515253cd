#include <gpsrecon/core/repair_topology.h>

#include <gpsrecon/core/disjoint_sets.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <string>

namespace gpsrecon {
namespace {

/// Faces with at least three different corners, none twice and none over the corners of another.
std::vector<std::vector<Index>> proper_faces(const FaceList& faces, std::size_t vertex_count, TopologyRepair& repair) {
  std::vector<std::vector<Index>> kept;
  std::set<std::vector<Index>> seen;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::vector<Index> corners(faces[f].begin(), faces[f].end()), sorted = corners;
    std::sort(sorted.begin(), sorted.end());
    if (!sorted.empty() && sorted.back() >= vertex_count)
      throw InvariantError("repair: face " + std::to_string(f) + " has a corner out of range");
    const bool repeats = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
    if (corners.size() < 3 || repeats || !seen.insert(sorted).second)
      ++repair.dropped_faces;
    else
      kept.push_back(std::move(corners));
  }
  return kept;
}

/// A side of a face: from its corner k to the next.
struct Side {
  Index face, k;
};

struct Pair {
  Side a, b;
  bool agree;  ///< they run in opposite directions
};

/// Sides of edges with just two faces. Edges with more are cut, and counted.
std::vector<Pair> pairs_of(const std::vector<std::vector<Index>>& faces, TopologyRepair& repair) {
  std::map<std::pair<Index, Index>, std::vector<Side>> sides;
  for (Index f = 0; f < faces.size(); ++f)
    for (Index k = 0; k < faces[f].size(); ++k) {
      const Index a = faces[f][k], b = faces[f][(k + 1) % faces[f].size()];
      sides[{std::min(a, b), std::max(a, b)}].push_back({f, k});
    }
  std::vector<Pair> pairs;
  for (const auto& [edge, at] : sides) {
    if (at.size() > 2) ++repair.cut_edges;
    if (at.size() != 2) continue;
    pairs.push_back({at[0], at[1], faces[at[0].face][at[0].k] != faces[at[1].face][at[1].k]});
  }
  return pairs;
}

/// Which faces to turn so that those of a pair agree, as far as they can; pairs that cannot are left out.
std::vector<Pair> orient(const std::vector<std::vector<Index>>& faces, const std::vector<Pair>& pairs,
                         std::vector<bool>& turned, TopologyRepair& repair) {
  std::vector<std::vector<std::size_t>> around(faces.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    around[pairs[p].a.face].push_back(p);
    around[pairs[p].b.face].push_back(p);
  }
  std::vector<int> sign(faces.size(), 0);
  for (Index first = 0; first < faces.size(); ++first) {
    if (sign[first] != 0) continue;
    sign[first] = 1;
    std::vector<Index> piece{first};
    for (std::size_t at = 0; at < piece.size(); ++at)
      for (const std::size_t p : around[piece[at]]) {
        const Index other = pairs[p].a.face == piece[at] ? pairs[p].b.face : pairs[p].a.face;
        if (sign[other] != 0) continue;
        sign[other] = pairs[p].agree ? sign[piece[at]] : -sign[piece[at]];
        piece.push_back(other);
      }
    const auto minority = std::count_if(piece.begin(), piece.end(), [&](Index f) { return sign[f] < 0; });
    if (2 * static_cast<std::size_t>(minority) > piece.size())
      for (const Index f : piece) sign[f] = -sign[f];
  }
  std::vector<Pair> joined;
  for (const Pair& pair : pairs) {
    if ((sign[pair.a.face] == sign[pair.b.face]) == pair.agree)
      joined.push_back(pair);
    else
      ++repair.torn_edges;
  }
  turned.assign(faces.size(), false);
  for (Index f = 0; f < faces.size(); ++f) turned[f] = sign[f] < 0;
  repair.turned_faces += static_cast<std::size_t>(std::count(turned.begin(), turned.end(), true));
  return joined;
}

/// Gives every set of corners of a vertex that hang together by joined sides a vertex of their own, and turns faces.
void part(std::vector<std::vector<Index>>& faces, const std::vector<Pair>& joined, const std::vector<bool>& turned,
          TopologyRepair& repair) {
  std::vector<Index> first(faces.size() + 1, 0);
  for (Index f = 0; f < faces.size(); ++f) first[f + 1] = first[f] + static_cast<Index>(faces[f].size());
  DisjointSets sets(first.back());
  for (const Pair& pair : joined)
    for (const Index end : {0U, 1U}) {
      const Index k = (pair.a.k + end) % static_cast<Index>(faces[pair.a.face].size());
      const std::vector<Index>& other = faces[pair.b.face];
      const Index next = (pair.b.k + 1) % static_cast<Index>(other.size());
      const Index match = other[pair.b.k] == faces[pair.a.face][k] ? pair.b.k : next;
      sets.join(first[pair.a.face] + k, first[pair.b.face] + match);
    }
  std::vector<Index> vertex(first.back(), no_index);
  std::vector<bool> taken(repair.origin.size(), false);
  for (Index f = 0; f < faces.size(); ++f)
    for (Index k = 0; k < faces[f].size(); ++k) {
      const Index set = sets.find(first[f] + k);
      if (vertex[set] == no_index) {
        const Index old = faces[f][k];
        if (!taken[old]) {
          taken[old] = true;
          vertex[set] = old;
        } else {
          vertex[set] = static_cast<Index>(repair.origin.size());
          repair.origin.push_back(repair.origin[old]);
          ++repair.copies;
        }
      }
    }
  for (Index f = 0; f < faces.size(); ++f) {
    std::vector<Index> corners;
    for (Index k = 0; k < faces[f].size(); ++k) corners.push_back(vertex[sets.find(first[f] + k)]);
    if (turned[f]) std::reverse(corners.begin() + 1, corners.end());
    faces[f] = std::move(corners);
  }
}

}  // namespace

TopologyRepair repair_topology(const FaceList& faces, std::size_t vertex_count) {
  TopologyRepair repair;
  repair.origin.resize(vertex_count);
  std::iota(repair.origin.begin(), repair.origin.end(), Index{0});
  std::vector<std::vector<Index>> left = proper_faces(faces, vertex_count, repair);
  // Sheets that were parted along an edge may still hang together around both of its ends. Then the edge is there
  // again, and the last of its faces has to go.
  for (;;) {
    std::vector<bool> turned;
    const std::vector<Pair> joined = orient(left, pairs_of(left, repair), turned, repair);
    part(left, joined, turned, repair);
    repair.faces = {};
    for (const std::vector<Index>& f : left) repair.faces.add(f);
    const Topology result = topology(repair.faces, repair.origin.size());
    if (result.manifold()) return repair;
    std::map<std::pair<Index, Index>, int> count;
    std::vector<std::vector<Index>> kept;
    for (const std::vector<Index>& f : left) {
      bool fits = true;
      for (std::size_t k = 0; k < f.size(); ++k) fits = fits && count[{f[k], f[(k + 1) % f.size()]}] == 0;
      if (fits)
        for (std::size_t k = 0; k < f.size(); ++k) count[{f[k], f[(k + 1) % f.size()]}] = 1;
      if (fits)
        kept.push_back(f);
      else
        ++repair.dropped_faces;
    }
    if (kept.size() == left.size()) throw InvariantError("repair: the faces cannot be made manifold");
    left = std::move(kept);
  }
}

}  // namespace gpsrecon
