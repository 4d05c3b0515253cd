// Cutting and stitching to a manifold: Guéziec et al. 2001, each vertex split by its fans. It works on
// a face list, not on an editable mesh: half-edges cannot hold what it is there to repair.

#include <gpsrecon/core/repair_topology.h>

#include <gpsrecon/core/disjoint_sets.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <utility>

namespace gpsrecon {

using namespace internal;
namespace {

/// Faces with at least three different corners, none twice and none over the corners of another.
FaceList proper_faces(const FaceList& faces, std::size_t vertex_count, TopologyRepair& repair) {
  FaceList kept;
  std::set<std::vector<Index>> seen;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::vector<Index> sorted(faces[f].begin(), faces[f].end());
    std::sort(sorted.begin(), sorted.end());
    if (!sorted.empty() && sorted.back() >= vertex_count)
      throw InvariantError("repair: face " + std::to_string(f) + " has a corner out of range");
    const bool repeats = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
    if (sorted.size() < 3 || repeats || !seen.insert(std::move(sorted)).second)
      ++repair.dropped_faces;
    else
      kept.add(faces[f]);
  }
  return kept;
}

/// The two half-edges of an edge, whichever way they run.
struct Pair {
  Index a, b;
};
bool agree(const Connectivity& c, const Pair& pair) {
  return c.source(pair.a) != c.source(pair.b);
}

/// Pairs in the order of their vertices. Edges of more than two half-edges are cut, and counted.
std::vector<Pair> find_pairs(const Connectivity& c, TopologyRepair& repair) {
  repair.cut_edges += c.nonmanifold_edges;
  std::vector<Pair> of_edge(c.edge_count(), {no_index, no_index});
  std::vector<Index> halves(c.edge_count(), 0);
  for (Index h = 0; h < c.half_edge_count(); ++h) {
    const Index e = c.edge[h];
    (halves[e]++ == 0 ? of_edge[e].a : of_edge[e].b) = h;
  }
  std::vector<Pair> pairs;
  for (std::size_t e = 0; e < halves.size(); ++e)
    if (halves[e] == 2) pairs.push_back(of_edge[e]);
  const auto ends = [&c](const Pair& pair) { return std::minmax({c.source(pair.a), c.target(pair.a)}); };
  std::sort(pairs.begin(), pairs.end(), [&](const Pair& x, const Pair& y) { return ends(x) < ends(y); });
  return pairs;
}

/// Which faces to turn so that those of a pair agree, as far as they can; pairs that cannot are left out.
std::vector<Pair> orient(const Connectivity& c, const std::vector<Pair>& pairs, std::vector<bool>& turned,
                         TopologyRepair& repair) {
  std::vector<std::vector<std::size_t>> around(c.face_total());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    around[c.face(pairs[p].a)].push_back(p);
    around[c.face(pairs[p].b)].push_back(p);
  }
  std::vector<int> sign(around.size(), 0);
  for (Index first = 0; first < sign.size(); ++first) {
    if (sign[first] != 0) continue;
    sign[first] = 1;
    std::vector<Index> piece{first};
    for (std::size_t at = 0; at < piece.size(); ++at)
      for (const std::size_t p : around[piece[at]]) {
        const Index a = c.face(pairs[p].a), other = a == piece[at] ? c.face(pairs[p].b) : a;
        if (sign[other] != 0) continue;
        sign[other] = agree(c, pairs[p]) ? sign[piece[at]] : -sign[piece[at]];
        piece.push_back(other);
      }
    const auto minority = std::count_if(piece.begin(), piece.end(), [&](Index f) { return sign[f] < 0; });
    if (2 * static_cast<std::size_t>(minority) > piece.size())
      for (const Index f : piece) sign[f] = -sign[f];
  }
  std::vector<Pair> joined;
  for (const Pair& pair : pairs) {
    if ((sign[c.face(pair.a)] == sign[c.face(pair.b)]) == agree(c, pair))
      joined.push_back(pair);
    else
      ++repair.torn_edges;
  }
  turned.assign(sign.size(), false);
  for (Index f = 0; f < sign.size(); ++f) turned[f] = sign[f] < 0;
  repair.turned_faces += static_cast<std::size_t>(std::count(turned.begin(), turned.end(), true));
  return joined;
}

/// Gives every set of corners of a vertex that hang together by joined pairs a vertex of their own, and turns faces.
FaceList part(const Connectivity& c, const std::vector<Pair>& joined, const std::vector<bool>& turned,
              TopologyRepair& repair) {
  DisjointSets sets(c.half_edge_count());
  for (const Pair& pair : joined)
    for (const Index corner : {pair.a, c.next(pair.a)}) {
      sets.join(corner, c.source(pair.b) == c.source(corner) ? pair.b : c.next(pair.b));
    }
  std::vector<Index> vertex(c.half_edge_count(), no_index);
  std::vector<bool> taken(repair.origin.size(), false);
  for (Index h = 0; h < c.half_edge_count(); ++h) {
    Index& of_set = vertex[sets.find(h)];
    if (of_set != no_index) continue;
    const Index old = c.source(h);
    of_set = taken[old] ? static_cast<Index>(repair.origin.size()) : old;
    if (taken[old]) {
      repair.origin.push_back(repair.origin[old]);
      ++repair.copies;
    }
    taken[old] = true;
  }
  FaceList faces = face_list(c);
  for (Index h = 0; h < c.half_edge_count(); ++h) faces.corners[h] = vertex[sets.find(h)];
  for (Index f = 0; f < turned.size(); ++f)
    if (turned[f])
      std::reverse(faces.corners.begin() + faces.offsets[f] + 1, faces.corners.begin() + faces.offsets[f + 1]);
  return faces;
}

/// The faces none of whose half-edges another has already.
FaceList without_repetitions(const FaceList& faces) {
  std::set<std::pair<Index, Index>> taken;
  FaceList kept;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::vector<std::pair<Index, Index>> sides;
    for (std::size_t k = 0; k < faces[f].size(); ++k)
      sides.emplace_back(faces[f][k], faces[f][(k + 1) % faces[f].size()]);
    if (std::any_of(sides.begin(), sides.end(), [&](const auto& side) { return taken.contains(side); })) continue;
    taken.insert(sides.begin(), sides.end());
    kept.add(faces[f]);
  }
  return kept;
}

}  // namespace

TopologyRepair repair_topology(const FaceList& faces, std::size_t vertex_count) {
  TopologyRepair repair;
  repair.origin.resize(vertex_count);
  std::iota(repair.origin.begin(), repair.origin.end(), Index{0});
  FaceList left = proper_faces(faces, vertex_count, repair);
  // Sheets that were parted along an edge may still hang together around both of its ends. Then the edge is there
  // again, and the last of its faces has to go.
  for (;;) {
    const Connectivity connectivity = build_connectivity(left, repair.origin.size());
    std::vector<bool> turned;
    const std::vector<Pair> joined = orient(connectivity, find_pairs(connectivity, repair), turned, repair);
    repair.faces = part(connectivity, joined, turned, repair);
    if (manifold_faults(build_connectivity(repair.faces, repair.origin.size())).empty()) return repair;
    left = without_repetitions(repair.faces);
    if (left.size() == repair.faces.size()) throw InvariantError("repair: the faces cannot be made manifold");
    repair.dropped_faces += repair.faces.size() - left.size();
  }
}

}  // namespace gpsrecon
