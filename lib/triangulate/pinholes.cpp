#include <gpsrecon/triangulate/pinholes.h>

#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/numbers.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numbers>

namespace gpsrecon::internal {
namespace {

/// The edge of the surface's boundary that bounds the same gap at v as the boundary edge from -> v: the first one met
/// when turning counter-clockwise from v -> from, through the gap. With a single fan there is no choice.
Index next_around_gap(const GrowingSurface& surface, Index from, Index v, std::vector<GrowingSurface::Fan>& fans) {
  surface.fans(v, fans);
  std::erase_if(fans, [](const auto& fan) { return fan.closed(); });
  if (fans.size() == 1) return fans.front().first;
  Vec3 normal = Vec3::Zero();
  for (const Index t : surface.triangles_around(v)) normal += surface.normal(t);
  if (normal.norm() == 0) return no_index;
  normal.normalize();
  const Vec3 start = surface.position(from) - surface.position(v);
  Index best = no_index;
  double best_angle = std::numeric_limits<double>::infinity();
  for (const auto& fan : fans) {
    const Vec3 direction = surface.position(fan.first) - surface.position(v);
    double angle = std::atan2(normal.dot(start.cross(direction)),
                              start.dot(direction) - normal.dot(start) * normal.dot(direction));
    if (angle <= 0) angle += 2 * std::numbers::pi;
    if (angle < best_angle) best_angle = angle, best = fan.first;
  }
  return best;
}

using Loop = std::vector<Index>;

struct Edge {
  Index from, to;
  friend bool operator<(const Edge& a, const Edge& b) { return std::pair(a.from, a.to) < std::pair(b.from, b.to); }
};

/// Boundary loops that run around gaps: where fans touch in a vertex, the loop crosses from one to the other.
std::vector<Loop> gap_loops(const GrowingSurface& surface) {
  std::vector<Edge> edges;
  for (Index t = 0; t < surface.triangle_slots(); ++t) {
    if (!surface.alive(t)) continue;
    const auto& corners = surface.triangle(t);
    for (std::size_t k = 0; k < 3; ++k)
      if (surface.on_front(corners[k], corners[(k + 1) % 3])) edges.push_back({corners[k], corners[(k + 1) % 3]});
  }
  std::sort(edges.begin(), edges.end());
  std::vector<char> seen(edges.size(), 0);
  const auto number = [&](Index from, Index to) {
    const auto at = std::lower_bound(edges.begin(), edges.end(), Edge{from, to});
    return static_cast<std::size_t>(at - edges.begin());
  };
  std::vector<Loop> loops;
  std::vector<GrowingSurface::Fan> fans;
  for (std::size_t start = 0; start < edges.size(); ++start) {
    if (seen[start]) continue;
    Loop loop;
    for (std::size_t e = start; !seen[e];) {
      seen[e] = 1;
      loop.push_back(edges[e].from);
      const Index next = next_around_gap(surface, edges[e].from, edges[e].to, fans);
      if (next == no_index) break;
      e = number(edges[e].to, next);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

bool simple(const Loop& loop) {
  Loop sorted = loop;
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
}

/// Per vertex the number of faces of the connected piece of surface it belongs to.
std::vector<std::size_t> piece_sizes(const GrowingSurface& surface) {
  const Connectivity he = build_connectivity(surface.faces(), surface.vertex_count());
  const Components pieces = face_components(he);
  std::vector<std::size_t> size(pieces.count, 0), of_vertex(surface.vertex_count(), 0);
  for (const Index piece : pieces.of_face) ++size[piece];
  for (Index h = 0; h < he.half_edge_count(); ++h) {
    std::size_t& largest = of_vertex[he.source(h)];
    largest = std::max(largest, size[pieces.of_face[he.face(h)]]);
  }
  return of_vertex;
}

/// A loop around a gap in the surface, not around a patch of it. A patch of F triangles has at least about sqrt(F)
/// edges around it; a longer loop is told by the way it runs: clockwise around a gap, seen from the side of the
/// normals.
bool surrounds_gap(const GrowingSurface& surface, const Loop& loop, std::size_t faces_of_piece) {
  if (loop.size() * loop.size() < faces_of_piece) return true;
  Vec3 area = Vec3::Zero(), normal = Vec3::Zero();
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Index from = loop[k], to = loop[(k + 1) % loop.size()];
    area +=
        (surface.position(from) - surface.position(loop.front())).cross(surface.position(to) - surface.position(from));
    const Index t = surface.triangle_at(from, to);
    if (t != no_index) normal += surface.normal(t);
  }
  return area.dot(normal) < 0;
}

/// The triangles that close a loop, or none.
using Patch = std::vector<GrowingSurface::Triangle>;

/// Adds all triangles if each is admissible when its turn comes, trying orders; otherwise leaves the surface as it was.
bool apply(GrowingSurface& surface, const TriangleJudge& judge, Patch patch) {
  std::vector<Index> added;
  while (!patch.empty()) {
    const auto next = std::find_if(patch.begin(), patch.end(),
                                   [&](const auto& t) { return judge.dihedral(t[0], t[1], t[2]).has_value(); });
    if (next == patch.end()) break;
    added.push_back(surface.add(*next));
    patch.erase(next);
  }
  if (patch.empty()) return true;
  for (auto t = added.rbegin(); t != added.rend(); ++t) surface.remove(*t);
  return false;
}

/// A fan around an unused component that overlaps every vertex of the loop: the hole is there because the component is
/// missing from the surface.
bool close_around_leftover(GrowingSurface& surface, const OverlapGraph& graph, const TriangleJudge& judge,
                           const Loop& loop) {
  struct Choice {
    double log_overlap;
    Index center;
  };
  std::vector<Choice> choices;
  for (const OverlapGraph::Link& link : graph[loop.front()]) {
    if (surface.used(link.to)) continue;
    double worst = 0;
    for (const Index v : loop) {
      const double* log_overlap = graph.find(link.to, v);
      worst = std::min(worst, log_overlap == nullptr ? -std::numeric_limits<double>::infinity() : *log_overlap);
    }
    if (std::isfinite(worst)) choices.push_back({worst, link.to});
  }
  std::sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
    return a.log_overlap != b.log_overlap ? a.log_overlap > b.log_overlap : a.center < b.center;
  });
  for (const Choice& choice : choices) {
    Patch patch;
    for (std::size_t k = 0; k < loop.size(); ++k)
      patch.push_back({loop[(k + 1) % loop.size()], loop[k], choice.center});
    if (apply(surface, judge, std::move(patch))) return true;
  }
  return false;
}

/// The triangulation of the loop, without new vertices, of least sum of -ln BC over its triangles' sides plus a penalty
/// for bending. Its sides may overlap a little less than the front asks for, BC >= BCmin³ (1.7 times the distance), as
/// the surface around vouches for them. Dynamic programming over sub-polygons, O(m³).
bool close_by_triangles(GrowingSurface& surface, const Mixture& mixture, double min_overlap, const TriangleJudge& judge,
                        const Loop& loop) {
  const std::size_t m = loop.size();
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<FactoredGaussian> gaussians;
  for (const Index v : loop) gaussians.emplace_back(mixture.component(v));
  const auto side = [&](std::size_t i, std::size_t j) {  // cost of the side between corners i < j
    if (j == i + 1 || (i == 0 && j == m - 1)) return 0.0;
    if (surface.has(loop[i], loop[j]) || surface.has(loop[j], loop[i])) return infinity;
    const double log_overlap = log_bhattacharyya(gaussians[i], gaussians[j]);
    return log_overlap < 3 * std::log(min_overlap) ? infinity : -log_overlap;
  };
  // Normals of the surface across the boundary edges, for the bend at the rim.
  const auto rim_normal = [&](std::size_t i) {
    return surface.normal(surface.triangle_at(loop[i], loop[(i + 1) % m]));
  };
  std::vector<double> cost(m * m, infinity);
  std::vector<std::size_t> split(m * m, 0);
  for (std::size_t i = 0; i + 1 < m; ++i) cost[i * m + i + 1] = 0;
  for (std::size_t width = 2; width < m; ++width)
    for (std::size_t i = 0; i + width < m; ++i) {
      const std::size_t j = i + width;
      const double outer = side(i, j);
      if (outer == infinity) continue;
      for (std::size_t k = i + 1; k < j; ++k) {
        double sum = cost[i * m + k] + cost[k * m + j] + outer;
        if (!(sum < cost[i * m + j])) continue;
        const Vec3 normal = surface.unit_normal(loop[j], loop[k], loop[i]);
        const auto bend = [&](std::size_t rim) { return 1 - normal.dot(rim_normal(rim)); };
        if (k == i + 1) sum += bend(i);
        if (j == k + 1) sum += bend(k);
        if (i == 0 && j == m - 1) sum += bend(m - 1);
        if (sum < cost[i * m + j]) cost[i * m + j] = sum, split[i * m + j] = k;
      }
    }
  if (cost[m - 1] == infinity) return false;
  Patch patch;
  std::vector<std::pair<std::size_t, std::size_t>> stack{{0, m - 1}};
  while (!stack.empty()) {
    const auto [i, j] = stack.back();
    stack.pop_back();
    if (j - i < 2) continue;
    const std::size_t k = split[i * m + j];
    patch.push_back({loop[j], loop[k], loop[i]});
    stack.push_back({i, k});
    stack.push_back({k, j});
  }
  return apply(surface, judge, std::move(patch));
}

std::size_t boundary_edges_at(const GrowingSurface& surface, const std::vector<Index>& vertices) {
  std::size_t count = 0;
  for (const Index v : vertices)
    for (const Index t : surface.triangles_around(v)) {
      const auto& corners = surface.triangle(t);
      for (std::size_t k = 0; k < 3; ++k) count += surface.on_front(corners[k], corners[(k + 1) % 3]) ? 1 : 0;
    }
  return count;
}

/// A loop that cannot be closed as it is, is knotted: its rim overlaps itself, or the sides it needs exist elsewhere.
/// Without the triangles along the rim it may close; if that leaves no less boundary, all is put back.
template <class Close>
bool reopen_and_close(GrowingSurface& surface, const Loop& loop, const Close& close) {
  std::vector<GrowingSurface::Triangle> rim;
  std::vector<Index> touched = loop;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Index t = surface.triangle_at(loop[k], loop[(k + 1) % loop.size()]);
    if (t != no_index) touched.push_back(surface.third_corner(t, loop[k], loop[(k + 1) % loop.size()]));
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  const std::size_t before = boundary_edges_at(surface, touched);
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Index t = surface.triangle_at(loop[k], loop[(k + 1) % loop.size()]);
    if (t == no_index) continue;
    rim.push_back(surface.triangle(t));
    surface.remove(t);
  }
  const std::size_t first_new = surface.triangle_slots();
  for (const Loop& wider : gap_loops(surface))
    if (std::any_of(wider.begin(), wider.end(),
                    [&](Index v) { return std::binary_search(touched.begin(), touched.end(), v); }))
      close(wider);
  if (boundary_edges_at(surface, touched) < before) return true;
  for (std::size_t t = surface.triangle_slots(); t-- > first_new;)
    if (surface.alive(static_cast<Index>(t))) surface.remove(static_cast<Index>(t));
  for (const GrowingSurface::Triangle& t : rim) surface.add(t);
  return false;
}

}  // namespace

std::size_t close_pinholes(GrowingSurface& surface, const Mixture& mixture, const OverlapGraph& graph,
                           const Sheets& sheets, const TriangulateOptions& options) {
  const auto max_edges = static_cast<std::size_t>(options.max_pinhole_edges);
  const std::vector<std::size_t> faces_of_piece = piece_sizes(surface);
  std::size_t closed = 0;
  const auto close = [&](const TriangleJudge& judge, const Loop& loop) {
    if (loop.size() < 3 || loop.size() > max_edges || !simple(loop)) return false;
    if (!surrounds_gap(surface, loop, faces_of_piece[loop.front()])) return false;
    for (std::size_t k = 0; k < loop.size(); ++k)
      if (!surface.on_front(loop[k], loop[(k + 1) % loop.size()])) return false;  // changed since it was found
    return close_around_leftover(surface, graph, judge, loop) ||
           close_by_triangles(surface, mixture, options.min_overlap, judge, loop);
  };
  const auto close_with = [&](const TriangleJudge& judge) {
    for (std::size_t before = closed + 1; before != closed;) {
      before = closed;
      for (const Loop& loop : gap_loops(surface)) closed += close(judge, loop) ? 1 : 0;
    }
  };
  // First by the rules of the front; then at angles and with slight overlaps that it shuns: a crumpled patch of a few
  // triangles does less harm than a hole.
  const TriangleJudge strict(graph, sheets, surface, radians(options.min_dihedral));
  const TriangleJudge lenient(graph, sheets, surface, 0.02, true);
  close_with(strict);
  close_with(lenient);
  for (const Loop& loop : gap_loops(surface))
    if (loop.size() <= max_edges && surrounds_gap(surface, loop, faces_of_piece[loop.front()]))
      closed += reopen_and_close(surface, loop, [&](const Loop& l) { return close(lenient, l); });
  return closed;
}

}  // namespace gpsrecon::internal
