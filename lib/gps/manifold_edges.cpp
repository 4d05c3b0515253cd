#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/manifold_edges.h>
#include <string>

namespace gpsrecon {

HalfEdges manifold_edges(const FaceList& faces, std::size_t vertex_count) {
  for (const Index v : faces.corners)
    if (v >= vertex_count) throw InvariantError("subdivision: vertex index " + std::to_string(v) + " is out of range");
  HalfEdges edges = half_edges(faces, vertex_count);
  if (edges.nonmanifold_edges > 0 || edges.inconsistent_edges > 0)
    throw InvariantError("subdivision: " + std::to_string(edges.nonmanifold_edges) + " non-manifold edges, " +
                         std::to_string(edges.inconsistent_edges) + " inconsistently oriented edges");
  const std::vector<Index> fans = vertex_fans(faces, edges, vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v)
    if (fans[v] > 1) throw InvariantError("subdivision: vertex " + std::to_string(v) + " is not manifold");
  return edges;
}

}  // namespace gpsrecon
