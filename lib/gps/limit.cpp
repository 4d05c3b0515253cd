#include <gpsrecon/gps/limit.h>
#include <array>
#include <cmath>
#include <numbers>

namespace gpsrecon {
namespace {

using std::numbers::pi;
using Mask = std::vector<LimitWeight>;

constexpr std::array unused_mask{LimitWeight{1, 0, 0}};
constexpr std::array corner_mask{LimitWeight{1, -1, -1}, LimitWeight{0, 1, 0}, LimitWeight{0, 0, 1}};

Mask interior_mask(LoopWeights weights, Index n) {
  const double omega = 1 / (n + 3 / (8 * loop_beta(weights, n)));
  Mask mask(n + 1);
  mask[0] = {1 - n * omega, 0, 0};
  for (Index j = 0; j < n; ++j) mask[j + 1] = {omega, std::cos(2 * pi * j / n), std::sin(2 * pi * j / n)};
  return mask;
}

/// Weights of v, r_0 .. r_k. The fan's subdivision matrix maps r_0, r_k to (v + r)/2, v to 3/4 v + (r_0 + r_k)/8 and
/// the inner r_i to 3/8 (v + r_i) + (r_{i-1} + r_{i+1})/8. Its symmetric left eigenvector with eigenvalue 3/8 + cos θ/4
/// has sin iθ at the inner r_i; solving the columns of r_0 and v for the rest gives -s at v and -s cos θ at r_0 and
/// r_k, with s = sin θ / ((1 - cos θ)(1 + 2 cos θ)).
Mask boundary_mask(Index k) {
  Mask mask(k + 2, LimitWeight{0, 0, 0});
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

LimitTable limit_table(const TriangleConnectivity& topology, LoopWeights weights, CornerRule corners,
                       const RunContext& context) {
  LimitTable table;
  table.columns = topology.vertex_count;
  const auto unused = table.add_mask(unused_mask), corner = table.add_mask(corner_mask);
  MasksByCount boundary(topology.face_count), interior(topology.face_count);
  table.masks.reserve(topology.vertex_count);
  table.offsets.reserve(topology.vertex_count + 1);
  for (Index v = 0; v < topology.vertex_count; ++v) {
    const Index n = topology.face_count[v];
    switch (loop_rule(topology, v, corners)) {
      case LoopRule::unused:
        table.add_row(unused, 1);
        break;
      case LoopRule::corner:
        table.add_row(corner, 3);
        break;
      case LoopRule::boundary:
        table.add_row(boundary.find_or_add(n, [&] { return table.add_mask(boundary_mask(n)); }), n + 2);
        break;
      case LoopRule::interior:
        table.add_row(interior.find_or_add(n, [&] { return table.add_mask(interior_mask(weights, n)); }), n + 1);
        break;
    }
  }
  table.indices.resize(table.offsets.back());
  parallel_for(topology.vertex_count, context, [&](std::size_t v) {
    const std::span<Index> row = table.row_indices(v);
    row[0] = static_cast<Index>(v);
    std::size_t at = 1;
    topology.for_each_neighbor(row[0], [&](Index r) { row[at++] = r; });
  });
  return table;
}

}  // namespace gpsrecon
