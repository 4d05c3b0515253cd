// Short loops that do not bound: the greedy homotopy basis of Erickson & Whittlesey 2005, with a tree and cotree
// (Eppstein 2003).

#include <gpsrecon/triangulate/handles.h>

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/disjoint_sets.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <optional>
#include <tuple>

namespace gpsrecon::internal {
namespace {

using Loop = std::vector<Index>;

/// What searches along the edges of a surface need.
struct Surface {
  const Connectivity& half_edges;
  VertexEdges at = vertex_edges(half_edges);

  Index source(Index e) const { return half_edges.source(half_edges.edge_start[e]); }
  Index target(Index e) const { return half_edges.target(half_edges.edge_start[e]); }
  Index other_end(Index e, Index v) const { return source(e) == v ? target(e) : source(e); }
};

/// Marks that are forgotten all at once.
class Marks {
 public:
  explicit Marks(std::size_t size) : value_(size, 0), round_(size, 0) {}
  void clear() { ++now_; }
  bool has(Index i) const { return round_[i] == now_; }
  Index operator[](Index i) const { return value_[i]; }
  void set(Index i, Index value) { round_[i] = now_, value_[i] = value; }

 private:
  std::vector<Index> value_;
  std::vector<std::uint64_t> round_;
  std::uint64_t now_ = 0;
};

class LoopFinder {
 public:
  LoopFinder(const Surface& surface, std::size_t max_edges)
      : surface_(surface),
        half_edges_(surface.half_edges),
        max_edges_(max_edges),
        number_(half_edges_.vertex_count),
        side_(half_edges_.face_total()) {}

  /// Appends the loops through `base`.
  void find(Index base, std::vector<Loop>& loops) {
    grow_ball(base);
    collect_faces();
    for (const Index edge : generators()) {
      std::optional<Loop> loop = loop_across(edge);
      if (loop && keeps_together(*loop)) loops.push_back(std::move(*loop));
    }
  }

 private:
  struct Reached {
    Index vertex, parent;  ///< parent: number within the ball
    std::size_t hops;
  };

  void grow_ball(Index base) {
    number_.clear();
    ball_.assign(1, {base, 0, 0});
    number_.set(base, 0);
    for (Index i = 0; i < ball_.size() && 2 * (ball_[i].hops + 1) <= max_edges_; ++i)
      for (const Index e : surface_.at[ball_[i].vertex]) {
        const Index to = surface_.other_end(e, ball_[i].vertex);
        if (number_.has(to)) continue;
        number_.set(to, static_cast<Index>(ball_.size()));
        ball_.push_back({to, i, ball_[i].hops + 1});
      }
  }

  /// Edges of the ball outside its tree, longest loop first, and a number for each face beside one of them: 0 for all
  /// that are not whole in the ball.
  void collect_faces() {
    edges_.clear();
    side_.clear();
    face_count_ = 1;
    const auto number_face = [&](Index h) {
      if (h == no_index) return Index{0};
      const Index f = half_edges_.face(h);
      if (!side_.has(f)) {
        const auto corners = half_edges_.corners.begin() + half_edges_.face_start(f);
        const bool whole = std::all_of(corners, corners + 3, [&](Index v) { return number_.has(v); });
        side_.set(f, whole ? face_count_++ : 0);
      }
      return side_[f];
    };
    for (Index i = 0; i < ball_.size(); ++i)
      for (const Index e : surface_.at[ball_[i].vertex]) {
        const Index to = surface_.other_end(e, ball_[i].vertex);
        if (!number_.has(to) || number_[to] < i) continue;
        const Index j = number_[to];
        if (ball_[j].parent == i && j != 0) continue;
        const Index h = half_edges_.edge_start[e];
        const Index left = number_face(h), right = number_face(half_edges_.opposite[h]);
        edges_.push_back({ball_[i].hops + ball_[j].hops + 1, e, left, right});
      }
    std::sort(edges_.begin(), edges_.end(), [](const BallEdge& a, const BallEdge& b) {
      return std::pair(a.loop_edges, a.edge) > std::pair(b.loop_edges, b.edge);
    });
  }

  /// Edges that neither the tree nor a maximum spanning tree of the faces across the other edges has.
  std::vector<Index> generators() {
    DisjointSets joined(face_count_);
    std::vector<Index> found;
    for (const BallEdge& e : edges_)
      if (!joined.join(e.left, e.right) && e.loop_edges <= max_edges_) found.push_back(e.edge);
    return found;
  }

  /// The tree's paths to both ends of an edge, and the edge, if they only share the base.
  std::optional<Loop> loop_across(Index edge) const {
    const auto path = [&](Index v) {
      Loop up;
      for (Index i = number_[v]; i != 0; i = ball_[i].parent) up.push_back(ball_[i].vertex);
      return up;
    };
    Loop loop = path(surface_.source(edge));
    const Loop back = path(surface_.target(edge));
    // Paths of a tree that share a vertex share the one next to the base.
    if (!loop.empty() && !back.empty() && loop.back() == back.back()) return std::nullopt;
    loop.push_back(ball_.front().vertex);
    loop.insert(loop.end(), back.rbegin(), back.rend());
    return loop;
  }

  /// The faces on both sides of the loop are connected otherwise than across it: searched from both sides in turn, so
  /// that a small piece that falls off is noticed when it is seen whole.
  bool keeps_together(const Loop& loop) {
    const auto crosses_loop = [&](Index h) {
      const Index a = half_edges_.source(h), b = half_edges_.target(h);
      for (std::size_t k = 0; k < loop.size(); ++k) {
        const Index c = loop[k], d = loop[(k + 1) % loop.size()];
        if ((a == c && b == d) || (a == d && b == c)) return true;
      }
      return false;
    };
    Index across = no_index;
    for (const Index e : surface_.at[loop[0]])
      if (surface_.other_end(e, loop[0]) == loop[1]) across = half_edges_.edge_start[e];
    if (half_edges_.opposite[across] == no_index) return false;
    side_.clear();
    std::array<std::vector<Index>, 2> queue;
    for (Index s = 0; s < 2; ++s) {
      queue[s].push_back(half_edges_.face(s == 0 ? across : half_edges_.opposite[across]));
      side_.set(queue[s][0], s);
    }
    for (std::array<std::size_t, 2> at{0, 0};;)
      for (Index s = 0; s < 2; ++s) {
        if (at[s] == queue[s].size()) return false;
        const Index f = queue[s][at[s]++];
        for (Index h = half_edges_.face_start(f); h < half_edges_.face_start(f + 1); ++h) {
          const Index opposite = half_edges_.opposite[h];
          if (opposite == no_index || crosses_loop(h)) continue;
          const Index g = half_edges_.face(opposite);
          if (side_.has(g) && side_[g] != s) return true;
          if (side_.has(g)) continue;
          side_.set(g, s);
          queue[s].push_back(g);
        }
      }
  }

  struct BallEdge {
    std::size_t loop_edges;
    Index edge, left, right;
  };

  const Surface& surface_;
  const Connectivity& half_edges_;
  std::size_t max_edges_;
  Marks number_;  ///< per vertex of the ball: its index in ball_
  Marks side_;    ///< per face: its number in the ball, or the side of a loop from which it was reached
  std::vector<Reached> ball_;
  std::vector<BallEdge> edges_;
  Index face_count_ = 0;
};

/// Begins with the smallest vertex and goes on with the smaller of its neighbours.
void normalize(Loop& loop) {
  std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  if (loop.back() < loop[1]) std::reverse(loop.begin() + 1, loop.end());
}

}  // namespace

std::size_t genus(const Connectivity& connectivity) {
  const Topology t = topology(connectivity);
  const long twice = 2 * static_cast<long>(t.components) - t.euler - static_cast<long>(t.boundary_loops);
  return static_cast<std::size_t>(std::max(twice, 0L) / 2);
}

std::vector<std::vector<Index>> handle_loops(const std::vector<Vec3>& positions, const FaceList& faces,
                                             std::size_t max_edges, const RunContext& context) {
  if (max_edges < 3) return {};
  const Connectivity half_edges = build_connectivity(faces, positions.size());
  if (genus(half_edges) == 0) return {};
  const Surface surface{half_edges};
  std::vector<std::vector<Loop>> of_block((positions.size() + parallel_block_size - 1) / parallel_block_size);
  parallel_blocks(positions.size(), context, [&](std::size_t block, std::size_t begin, std::size_t end) {
    LoopFinder finder(surface, max_edges);
    for (std::size_t v = begin; v < end; ++v) finder.find(static_cast<Index>(v), of_block[block]);
  });
  std::vector<Loop> loops;
  for (std::vector<Loop>& found : of_block) std::move(found.begin(), found.end(), std::back_inserter(loops));
  for (Loop& loop : loops) normalize(loop);
  std::sort(loops.begin(), loops.end());
  loops.erase(std::unique(loops.begin(), loops.end()), loops.end());

  const auto length = [&](const Loop& loop) {
    double sum = 0;
    for (std::size_t k = 0; k < loop.size(); ++k)
      sum += (positions[loop[(k + 1) % loop.size()]] - positions[loop[k]]).norm();
    return sum;
  };
  std::vector<std::pair<double, Index>> order;
  for (Index i = 0; i < loops.size(); ++i) order.emplace_back(length(loops[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<Loop> sorted;
  sorted.reserve(loops.size());
  for (const auto& [l, i] : order) sorted.push_back(std::move(loops[i]));
  return sorted;
}

}  // namespace gpsrecon::internal
