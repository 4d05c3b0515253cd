// Edge flips by the plausibility of Preiner et al. 2019, Eq. 20-22, as Lawson 1977 flips by angles. They flip
// the front's own triangles, not an editable mesh: fans of these may still touch in a vertex, and flipped triangles go
// to the end of the list, on which all later numbers depend.

#include <gpsrecon/triangulate/flips.h>

#include <gpsrecon/core/numbers.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace gpsrecon::internal {
namespace {

/// A gain below this is rounding.
constexpr double least_gain = 1e-9;

double angle_between(const Vec3& a, const Vec3& b) {
  return std::numbers::pi - std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

class Flipper {
 public:
  Flipper(GrowingSurface& surface, const OverlapGraph& graph, double min_dihedral)
      : surface_(surface), graph_(graph), min_dihedral_(min_dihedral) {}

  std::size_t run() {
    std::vector<Edge> edges;
    for (Index t = 0; t < surface_.triangle_slots(); ++t)
      if (surface_.alive(t)) append_edges(surface_.triangle(t), edges);
    std::size_t flips = 0;
    while (!edges.empty()) {
      std::vector<Edge> changed;
      for (const Edge& edge : edges) flips += flip(edge, changed) ? 1 : 0;
      edges = std::move(changed);
    }
    return flips;
  }

 private:
  struct Edge {
    Index a, b;
  };

  static void append_edges(const GrowingSurface::Triangle& t, std::vector<Edge>& edges) {
    for (std::size_t k = 0; k < 3; ++k) edges.push_back({t[k], t[(k + 1) % 3]});
  }

  bool flip(const Edge& edge, std::vector<Edge>& changed) {
    const auto [a, b] = edge;
    const Index left = surface_.triangle_at(a, b), right = surface_.triangle_at(b, a);
    if (left == no_index || right == no_index) return false;
    const Index c = surface_.third_corner(left, a, b), d = surface_.third_corner(right, a, b);
    if (c == d || surface_.has(c, d) || surface_.has(d, c)) return false;
    if (surface_.triangles_around(a).size() < 4 || surface_.triangles_around(b).size() < 4) return false;
    const double* new_overlap = graph_.find(c, d);
    if (new_overlap == nullptr) return false;
    const Vec3 at_a = surface_.unit_normal(a, d, c), at_b = surface_.unit_normal(d, b, c);
    const Vec3 &was_left = surface_.normal(left), &was_right = surface_.normal(right);
    if (at_a.isZero(0) || at_b.isZero(0)) return false;
    for (const Vec3& before : {was_left, was_right})
      if (at_a.dot(before) <= 0 || at_b.dot(before) <= 0) return false;

    const double* old_overlap = graph_.find(a, b);
    // Pinholes are closed by edges of less overlap, too; any edge of the graph is better than those.
    double gain = old_overlap == nullptr ? std::numeric_limits<double>::infinity() : *new_overlap - *old_overlap;
    const double new_angle = angle_between(at_a, at_b);
    double smallest = new_angle;
    gain += std::log(new_angle) - std::log(angle_between(was_left, was_right));
    struct Side {
      Index from, to;  // the half-edge of the neighbour
      const Vec3 &before, &after;
    };
    for (const Side& side : {Side{a, c, was_left, at_a}, Side{c, b, was_left, at_b}, Side{b, d, was_right, at_b},
                             Side{d, a, was_right, at_a}}) {
      const Index t = surface_.triangle_at(side.from, side.to);
      if (t == no_index) continue;
      const double after = angle_between(side.after, surface_.normal(t));
      smallest = std::min(smallest, after);
      gain += std::log(after) - std::log(angle_between(side.before, surface_.normal(t)));
    }
    if (smallest <= min_dihedral_ || !(gain > least_gain)) return false;
    surface_.remove(std::max(left, right));
    surface_.remove(std::min(left, right));
    surface_.add({a, d, c});
    surface_.add({d, b, c});
    for (const auto& [from, to] : {std::pair{a, c}, {c, b}, {b, d}, {d, a}}) changed.push_back({from, to});
    return true;
  }

  GrowingSurface& surface_;
  const OverlapGraph& graph_;
  double min_dihedral_;
};

}  // namespace

std::size_t flip_edges(GrowingSurface& surface, const OverlapGraph& graph, const TriangulateOptions& options) {
  return Flipper(surface, graph, radians(options.min_dihedral)).run();
}

}  // namespace gpsrecon::internal
