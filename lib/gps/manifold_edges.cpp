#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/manifold_edges.h>
#include <string>

namespace gpsrecon {

HalfEdges manifold_edges(const FaceList& faces, std::size_t vertex_count) {
  for (const Index v : faces.corners)
    if (v >= vertex_count) throw InvariantError("subdivision: vertex index " + std::to_string(v) + " is out of range");
  HalfEdges edges = half_edges(faces, vertex_count);
  const std::string faults = manifold_faults(faces, edges, vertex_count);
  if (!faults.empty()) throw InvariantError("subdivision: " + faults);
  return edges;
}

}  // namespace gpsrecon
