#include <gpsrecon/gps/loop.h>
#include <array>
#include <cmath>
#include <numbers>

namespace gpsrecon {
namespace {

using Topo = TriangleConnectivity;

constexpr std::array kept_mask{1.0};
constexpr std::array boundary_vertex_mask{3.0 / 4, 1.0 / 8, 1.0 / 8};
constexpr std::array boundary_edge_mask{1.0 / 2, 1.0 / 2};
constexpr std::array interior_edge_mask{3.0 / 8, 3.0 / 8, 1.0 / 8, 1.0 / 8};

std::vector<double> interior_vertex_mask(LoopWeights weights, Index n) {
  const double beta = loop_beta(weights, n);
  std::vector<double> mask(n + 1, beta);
  mask[0] = 1 - n * beta;
  return mask;
}

/// Masks and lengths of all rows, so that the rows can be filled in parallel.
void lay_out_rows(const Topo& topology, LoopWeights weights, CornerRule corners, StencilTable& table) {
  const auto kept = table.add_mask(kept_mask), boundary_vertex = table.add_mask(boundary_vertex_mask);
  const auto boundary_edge = table.add_mask(boundary_edge_mask), interior_edge = table.add_mask(interior_edge_mask);
  MasksByCount interior_vertex(topology.face_count);
  table.masks.reserve(topology.vertex_count + topology.edge_count());
  table.offsets.reserve(topology.vertex_count + topology.edge_count() + 1);
  for (Index v = 0; v < topology.vertex_count; ++v) {
    const Index n = topology.face_count[v];
    switch (loop_rule(topology, v, corners)) {
      case LoopRule::unused:
      case LoopRule::corner:
        table.add_row(kept, 1);
        break;
      case LoopRule::boundary:
        table.add_row(boundary_vertex, 3);
        break;
      case LoopRule::interior:
        table.add_row(interior_vertex.find_or_add(n, [&] { return table.add_mask(interior_vertex_mask(weights, n)); }),
                      n + 1);
        break;
    }
  }
  for (const Index h : topology.edge_start) {
    if (topology.opposite[h] == no_index) {
      table.add_row(boundary_edge, 2);
    } else {
      table.add_row(interior_edge, 4);
    }
  }
  table.indices.resize(table.offsets.back());
}

void fill_vertex_row(const Topo& topology, Index v, CornerRule corners, std::span<Index> row) {
  row[0] = v;
  switch (loop_rule(topology, v, corners)) {
    case LoopRule::unused:
    case LoopRule::corner:
      break;
    case LoopRule::boundary: {
      // Only the first and the last neighbour lie on the boundary.
      std::size_t seen = 0;
      topology.for_each_neighbor(v, [&](Index r) { row[seen++ == 0 ? 1 : 2] = r; });
      break;
    }
    case LoopRule::interior: {
      std::size_t at = 1;
      topology.for_each_neighbor(v, [&](Index r) { row[at++] = r; });
      break;
    }
  }
}

void fill_edge_row(const Topo& topology, Index h, std::span<Index> row) {
  row[0] = topology.source(h);
  row[1] = topology.target(h);
  if (row.size() == 2) return;
  row[2] = topology.source(Topo::previous(h));
  row[3] = topology.source(Topo::previous(topology.opposite[h]));
}

}  // namespace

double loop_beta(LoopWeights weights, Index n) {
  if (weights == LoopWeights::warren) return n == 3 ? 3.0 / 16 : 3.0 / (8.0 * n);
  const double c = 3.0 / 8 + std::cos(2 * std::numbers::pi / n) / 4;
  return (5.0 / 8 - c * c) / n;
}

StencilTable loop_stencils(const TriangleConnectivity& topology, LoopWeights weights, CornerRule corners,
                           const RunContext& context) {
  StencilTable table;
  table.columns = topology.vertex_count;
  lay_out_rows(topology, weights, corners, table);
  const std::size_t vertices = topology.vertex_count;
  parallel_for(vertices, context,
               [&](std::size_t v) { fill_vertex_row(topology, static_cast<Index>(v), corners, table.row_indices(v)); });
  parallel_for(topology.edge_count(), context, [&](std::size_t e) {
    fill_edge_row(topology, topology.edge_start[e], table.row_indices(vertices + e));
  });
  return table;
}

Refinement loop_refine(const FaceList& faces, std::size_t vertex_count, LoopWeights weights, CornerRule corners,
                       const RunContext& context) {
  const Topo topology = triangle_connectivity(faces, vertex_count);
  return {take_faces(refine(topology, context)), loop_stencils(topology, weights, corners, context)};
}

}  // namespace gpsrecon
