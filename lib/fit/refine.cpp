// Longest-edge bisection: Rivara 1984. New vertices: the product of Gaussians by the edge rule of Loop 1987.

#include <gpsrecon/fit/refine.h>

#include <gpsrecon/core/parallel.h>
#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/loop.h>
#include <algorithm>
#include <array>
#include <numeric>

namespace gpsrecon::internal {
namespace {

using Topo = Connectivity;

/// Fewer points around an edge do not settle whether it is to be split.
constexpr double min_points = 4;
/// The bound that the squared sum of weighted residuals must exceed takes every weight for the largest, a half, and so
/// is about five times what pure noise gives: few edges in a hundred pass by chance.
constexpr double largest_weight = 0.5;

/// Per face the half-edge of its longest edge.
std::vector<Index> longest_half_edges(const CovMesh& mesh, const Topo& topology) {
  const auto squared_length = [&](Index e) {
    const Index h = topology.edge_start[e];
    return (mesh.vertices.means[topology.source(h)] - mesh.vertices.means[topology.target(h)]).squaredNorm();
  };
  std::vector<Index> longest(mesh.faces.size());
  for (Index f = 0; f < longest.size(); ++f) {
    longest[f] = 3 * f;
    for (Index h = 3 * f + 1; h < 3 * f + 3; ++h)
      if (squared_length(topology.edge[h]) > squared_length(topology.edge[longest[f]])) longest[f] = h;
  }
  return longest;
}

/// Marks the longest edge of every triangle with a marked one, starting with the triangles in `open`, until nothing
/// changes. Returns the edges it marked.
std::vector<Index> mark_longest_edges(const Topo& topology, const std::vector<Index>& longest_half_edge,
                                      std::vector<Index> open, std::vector<char>& marked) {
  std::vector<Index> added;
  const auto longest = [&](Index f) { return topology.edge[longest_half_edge[f]]; };
  while (!open.empty()) {
    const Index f = open.back();
    open.pop_back();
    if (marked[longest(f)]) continue;
    if (!marked[topology.edge[3 * f]] && !marked[topology.edge[3 * f + 1]] && !marked[topology.edge[3 * f + 2]])
      continue;
    marked[longest(f)] = 1;
    added.push_back(longest(f));
    const Index other = topology.opposite[longest_half_edge[f]];
    if (other != no_index) open.push_back(other / 3);
  }
  return added;
}

std::vector<Index> all_faces(const CovMesh& mesh) {
  std::vector<Index> faces(mesh.faces.size());
  std::iota(faces.begin(), faces.end(), Index{0});
  return faces;
}

/// The part of the edges at an interior vertex that is marked; 0 on the boundary.
double marked_share(const Topo& topology, Index v, const std::vector<char>& marked) {
  if (topology.unused(v) || topology.on_boundary(v)) return 0;
  double share = 0;
  Index h = topology.vertex_start[v];
  do {
    share += marked[topology.edge[h]] ? 1.0 / topology.face_count[v] : 0;
    h = topology.opposite[topology.previous(h)];
  } while (h != topology.vertex_start[v]);
  return share;
}

/// Every vertex keeps one part of its weight and gives half as much to each new vertex on its edges.
void share_weights(const std::vector<double>& weights, const Topo& topology, const std::vector<Index>& middle,
                   std::vector<double>& shared) {
  std::vector<double> part(weights.size(), 1);
  const auto ends = [&](Index e) {
    const Index h = topology.edge_start[e];
    return std::array{topology.source(h), topology.target(h)};
  };
  for (Index e = 0; e < middle.size(); ++e)
    if (middle[e] != no_index)
      for (const Index v : ends(e)) part[v] += 0.5;
  for (std::size_t v = 0; v < part.size(); ++v) shared[v] = part[v] = weights[v] / part[v];
  for (Index e = 0; e < middle.size(); ++e) {
    if (middle[e] == no_index) continue;
    const auto [a, b] = ends(e);
    shared[middle[e]] = 0.5 * (part[a] + part[b]);
  }
}

/// The triangles of one face, given by its corners and the vertices on its edges (no_index: not split), starting with
/// the longest edge; that one is split if any is.
void add_pieces(const std::array<Index, 3>& corner, const std::array<Index, 3>& middle, FaceList& faces) {
  const auto add = [&](Index a, Index b, Index c) { faces.add(std::array<Index, 3>{a, b, c}); };
  const auto [a, b, c] = corner;
  const auto [ab, bc, ca] = middle;
  if (ab == no_index) {
    add(a, b, c);
  } else if (bc != no_index && ca != no_index) {
    add(a, ab, ca);
    add(b, bc, ab);
    add(c, ca, bc);
    add(ab, bc, ca);
  } else {
    if (ca != no_index) {
      add(a, ab, ca);
      add(ab, c, ca);
    } else {
      add(a, ab, c);
    }
    if (bc != no_index) {
      add(ab, b, bc);
      add(ab, bc, c);
    } else {
      add(ab, b, c);
    }
  }
}

}  // namespace

std::vector<double> edges_with_detail(const LimitSurface& surface, const Connectivity& topology,
                                      const Residuals& residuals) {
  // The vertices of the first refinement are the control vertices and one per edge: its basis function is the test.
  const std::vector<double> points = surface.to_level<double>(residuals.weight, 1);
  const std::vector<double> moment = surface.to_level<double>(residuals.moment, 1);
  const std::vector<double> square = surface.to_level<double>(residuals.square, 1);
  std::vector<double> evidence(topology.edge_count(), 0);
  for (std::size_t e = 0; e < evidence.size(); ++e) {
    const std::size_t v = topology.vertex_count + e;
    if (points[v] < min_points || topology.opposite[topology.edge_start[e]] == no_index) continue;
    const double chance = largest_weight * square[v];
    if (moment[v] * moment[v] > chance) evidence[e] = moment[v] * moment[v] / chance;
  }
  return evidence;
}

std::vector<char> strongest_edges(const CovMesh& mesh, const Connectivity& topology,
                                  const std::vector<double>& evidence, std::size_t most) {
  const std::vector<Index> longest = longest_half_edges(mesh, topology);
  std::vector<char> marked(evidence.size(), 0);
  std::vector<Index> order;
  for (Index e = 0; e < evidence.size(); ++e)
    if (evidence[e] > 0) order.push_back(e);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return evidence[a] > evidence[b]; });
  std::size_t count = 0;
  for (const Index e : order) {
    if (marked[e]) continue;
    marked[e] = 1;
    std::vector<Index> faces;
    for (const Index h : {topology.edge_start[e], topology.opposite[topology.edge_start[e]]})
      if (h != no_index) faces.push_back(h / 3);
    std::vector<Index> added = mark_longest_edges(topology, longest, std::move(faces), marked);
    added.push_back(e);
    // What does not fit is taken back; a weaker edge may need fewer others.
    if (added.size() <= most - count)
      count += added.size();
    else
      for (const Index undo : added) marked[undo] = 0;
  }
  return marked;
}

CovMesh split_edges(const CovMesh& mesh, const Connectivity& topology, std::vector<char> marked,
                    const RunContext& context) {
  const std::size_t n = mesh.vertices.size(), face_count = mesh.faces.size();
  const std::vector<Index> longest = longest_half_edges(mesh, topology);
  mark_longest_edges(topology, longest, all_faces(mesh), marked);

  const StencilTable step = loop_stencils(topology, mesh.rules.weights, mesh.rules.corners, context);
  std::vector<DualPoint> dual(n);
  parallel_for(n, context, [&](std::size_t i) { dual[i] = to_dual(mesh.vertices.component(i)); });
  const auto refined = [&](std::size_t row) { return from_dual(apply_row<DualPoint>(step.row(row), dual)); };

  // New vertices start as copies of an end of their edge, with all that vertices carry.
  std::vector<Index> origin(n), middle(marked.size(), no_index);
  std::iota(origin.begin(), origin.end(), Index{0});
  for (Index e = 0; e < marked.size(); ++e) {
    if (!marked[e]) continue;
    middle[e] = static_cast<Index>(origin.size());
    origin.push_back(topology.source(topology.edge_start[e]));
  }
  CovMesh fine;
  fine.rules = mesh.rules;
  fine.vertices = select(mesh.vertices, origin);
  parallel_for(n, context, [&](std::size_t v) {
    const double share = marked_share(topology, static_cast<Index>(v), marked);
    if (share == 0) return;
    const Gaussian target = refined(v);
    fine.vertices.means[v] += share * (target.mean - fine.vertices.means[v]);
    fine.vertices.covariances[v] = (1 - share) * fine.vertices.covariances[v] + share * target.covariance;
  });
  parallel_for(marked.size(), context, [&](std::size_t e) {
    if (!marked[e]) return;
    const Gaussian target = refined(n + e);
    fine.vertices.means[middle[e]] = target.mean;
    fine.vertices.covariances[middle[e]] = target.covariance;
  });
  share_weights(mesh.vertices.weights, topology, middle, fine.vertices.weights);
  fine.faces.reserve(4 * face_count, 12 * face_count);
  for (Index f = 0; f < face_count; ++f) {
    std::array<Index, 3> corner, on_edge;
    for (Index k = 0; k < 3; ++k) {
      const Index h = 3 * f + (longest[f] + k) % 3;
      corner[k] = topology.corners[h];
      on_edge[k] = middle[topology.edge[h]];
    }
    add_pieces(corner, on_edge, fine.faces);
  }
  return fine;
}

}  // namespace gpsrecon::internal
