#include <gpsrecon/gps/loop.h>

#include <gpsrecon/gps/boundary_masks.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <array>
#include <cmath>
#include <numbers>

namespace gpsrecon {
namespace {

using Topo = Connectivity;

constexpr std::array interior_edge_mask{3.0 / 8, 3.0 / 8, 1.0 / 8, 1.0 / 8};

std::vector<double> interior_vertex_mask(LoopWeights weights, Index n) {
  const double beta = loop_beta(weights, n);
  std::vector<double> mask(n + 1, beta);
  mask[0] = 1 - n * beta;
  return mask;
}

}  // namespace

double loop_beta(LoopWeights weights, Index n) {
  if (weights == LoopWeights::warren) return n == 3 ? 3.0 / 16 : 3.0 / (8.0 * n);
  const double c = 3.0 / 8 + std::cos(2 * std::numbers::pi / n) / 4;
  return (5.0 / 8 - c * c) / n;
}

LoopRows::LoopRows(const Connectivity& connectivity, LoopWeights weights, CornerRule corners)
    : connectivity_(connectivity),
      corners_(corners),
      kept_(masks_.add(kept_mask)),
      boundary_vertex_(masks_.add(boundary_vertex_mask)),
      boundary_edge_(masks_.add(boundary_edge_mask)),
      interior_edge_(masks_.add(interior_edge_mask)),
      interior_vertex_(masks_.add_by_count(connectivity.face_count, [&](Index n) {
        return n == 0 ? std::vector<double>{1.0} : interior_vertex_mask(weights, n);
      })) {}

Mask LoopRows::mask(std::size_t r) const {
  const Topo& topology = connectivity_;
  if (r >= topology.vertex_count) {
    const Index h = topology.edge_start[r - topology.vertex_count];
    return topology.opposite[h] == no_index ? boundary_edge_ : interior_edge_;
  }
  const auto v = static_cast<Index>(r);
  switch (loop_rule(topology, v, corners_)) {
    case LoopRule::boundary:
      return boundary_vertex_;
    case LoopRule::interior:
      return interior_vertex_[topology.face_count[v]];
    default:
      return kept_;
  }
}

void LoopRows::fill(std::size_t r, std::span<Index> row) const {
  const Topo& topology = connectivity_;
  if (r >= topology.vertex_count) {
    const Index h = topology.edge_start[r - topology.vertex_count];
    row[0] = topology.source(h);
    row[1] = topology.target(h);
    if (row.size() == 2) return;
    row[2] = topology.source(topology.previous(h));
    row[3] = topology.source(topology.previous(topology.opposite[h]));
    return;
  }
  const auto v = static_cast<Index>(r);
  row[0] = v;
  if (row.size() == 1) return;
  if (topology.on_boundary(v)) {
    // Only the first and the last neighbour lie on the boundary.
    row[1] = topology.target(topology.vertex_start[v]);
    topology.for_each_edge(v, [&](Index h, bool) { row[2] = topology.source(h); });
    return;
  }
  std::size_t at = 1;
  topology.for_each_edge(v, [&](Index h, bool) { row[at++] = topology.target(h); });
}

StencilTable loop_stencils(const Connectivity& topology, LoopWeights weights, CornerRule corners,
                           const RunContext& context) {
  return tabulate(LoopRows(topology, weights, corners), context);
}

Refinement loop_refine(const FaceList& faces, std::size_t vertex_count, LoopWeights weights, CornerRule corners,
                       const RunContext& context) {
  const Topo topology = triangle_connectivity(faces, vertex_count);
  return {refined_triangles(topology, context), loop_stencils(topology, weights, corners, context)};
}

}  // namespace gpsrecon
