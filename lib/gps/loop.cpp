// Loop 1987; Warren's weights: Warren & Weimer 2002; boundary rules: Hoppe et al. 1994.

#include <gpsrecon/gps/loop.h>

#include <gpsrecon/gps/refined_connectivity.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gpsrecon::internal {
namespace {

using std::numbers::pi;
using Topo = Connectivity;

constexpr std::array interior_edge_mask{3.0 / 8, 3.0 / 8, 1.0 / 8, 1.0 / 8};

std::vector<double> interior_vertex_mask(LoopWeights weights, Index n) {
  const double beta = loop_beta(weights, n);
  std::vector<double> mask(n + 1, beta);
  mask[0] = 1 - n * beta;
  return mask;
}

using LimitMask = std::vector<LimitWeight>;

LimitMask interior_limit_mask(LoopWeights weights, Index n) {
  const double omega = 1 / (n + 3 / (8 * loop_beta(weights, n)));
  LimitMask mask(n + 1);
  mask[0] = {1 - n * omega, 0, 0};
  for (Index j = 0; j < n; ++j) mask[j + 1] = {omega, std::cos(2 * pi * j / n), std::sin(2 * pi * j / n)};
  return mask;
}

/// Weights of v, r_0 .. r_k. The fan's subdivision matrix maps r_0, r_k to (v + r)/2, v to 3/4 v + (r_0 + r_k)/8 and
/// the inner r_i to 3/8 (v + r_i) + (r_{i-1} + r_{i+1})/8. Its symmetric left eigenvector with eigenvalue 3/8 + cos θ/4
/// has sin iθ at the inner r_i; solving the columns of r_0 and v for the rest gives -s at v and -s cos θ at r_0 and
/// r_k, with s = sin θ / ((1 - cos θ)(1 + 2 cos θ)).
LimitMask boundary_limit_mask(Index k) {
  LimitMask mask(k + 2, LimitWeight{0, 0, 0});
  mask[0].position = 2.0 / 3;
  mask[1] = {1.0 / 6, 1, 0};
  mask[k + 1] = {1.0 / 6, -1, 0};
  if (k == 1) {
    // No inner neighbour: what is left across the boundary is the curvature of the boundary curve itself.
    mask[0].v = -2;
    mask[1].v = mask[2].v = 1;
    return mask;
  }
  const double theta = pi / k, c = std::cos(theta);
  const double s = std::sin(theta) / ((1 - c) * (1 + 2 * c));
  mask[0].v = -s;
  mask[1].v = mask[k + 1].v = -s * c;
  for (Index i = 1; i < k; ++i) mask[i + 1].v = std::sin(i * theta);
  return mask;
}

}  // namespace

double loop_beta(LoopWeights weights, Index n) {
  if (weights == LoopWeights::warren) return n == 3 ? 3.0 / 16 : 3.0 / (8.0 * n);
  const double c = 3.0 / 8 + std::cos(2 * pi / n) / 4;
  return (5.0 / 8 - c * c) / n;
}

LoopRows::LoopRows(const Connectivity& connectivity, LoopWeights weights, CornerRule corners)
    : StepRows(connectivity, corners, interior_edge_mask, [&](Index n) { return interior_vertex_mask(weights, n); }) {}

void LoopRows::fill(std::size_t r, std::span<Index> row) const {
  if (!interior_after_fill(r, row)) return;
  const Topo& topology = connectivity_;
  if (r >= topology.vertex_count) {
    row[2] = topology.source(topology.previous(half_edge(r)));
    row[3] = topology.source(topology.previous(topology.opposite[half_edge(r)]));
    return;
  }
  std::size_t at = 1;
  topology.for_each_leaving(row[0], [&](Index h) { row[at++] = topology.target(h); });
}

StencilTable loop_stencils(const Connectivity& topology, LoopWeights weights, CornerRule corners,
                           const RunContext& context) {
  return tabulate(LoopRows(topology, weights, corners), context);
}

LoopLimitRows::LoopLimitRows(const Connectivity& connectivity, LoopWeights weights, CornerRule corners, bool refined)
    : LimitRows(
          connectivity, corners, refined, 6, boundary_limit_mask,
          [&](Index n) { return interior_limit_mask(weights, n); }, connectivity.face_count) {}

Mask LoopLimitRows::mask(std::size_t r) const {
  const std::size_t vertices = connectivity_.vertex_count;
  return r < vertices ? vertex_mask(static_cast<Index>(r)) : edge_mask(r - vertices);
}

void LoopLimitRows::fill(std::size_t r, std::span<Index> row) const {
  const Topo& topology = connectivity_;
  const auto vertices = static_cast<Index>(topology.vertex_count);
  row[0] = static_cast<Index>(r);
  std::size_t at = 1;
  if (r < vertices) {
    topology.for_each_edge(row[0], [&](Index h, bool arriving) {
      row[at++] = refined_ ? vertices + topology.edge[h] : arriving ? topology.source(h) : topology.target(h);
    });
    return;
  }
  // Around the middle of an edge: its target, the other two edges of the face, its source, and those of the other face.
  const Index h = topology.edge_start[r - vertices], other = topology.opposite[h];
  row[at++] = topology.target(h);
  const auto add_edges_of = [&](Index g) {
    row[at++] = vertices + topology.edge[topology.next(g)];
    row[at++] = vertices + topology.edge[topology.previous(g)];
  };
  add_edges_of(h);
  row[at++] = topology.source(h);
  if (other != no_index) add_edges_of(other);
}

LimitTable limit_table(const Connectivity& topology, LoopWeights weights, CornerRule corners,
                       const RunContext& context) {
  return tabulate(LoopLimitRows(topology, weights, corners, false), context);
}

Refinement loop_refine(const FaceList& faces, std::size_t vertex_count, LoopWeights weights, CornerRule corners,
                       const RunContext& context) {
  const Topo topology = triangle_connectivity(faces, vertex_count);
  return {refined_triangles(topology, context), loop_stencils(topology, weights, corners, context)};
}

}  // namespace gpsrecon::internal
