#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/gps/connectivity.h>
#include <string>

namespace gpsrecon {

Connectivity connectivity(const FaceList& faces, std::size_t vertex_count) {
  for (const Index v : faces.corners)
    if (v >= vertex_count) throw InvariantError("subdivision: vertex index " + std::to_string(v) + " is out of range");
  HalfEdges half = half_edges(faces, vertex_count);
  const std::string faults = manifold_faults(faces, half, vertex_count);
  if (!faults.empty()) throw InvariantError("subdivision: " + faults);

  Connectivity c;
  c.vertex_count = vertex_count;
  c.corners = faces.corners;
  c.opposite = std::move(half.opposite);
  c.edge.resize(c.corners.size());
  c.edge_start.reserve(half.edges);
  c.vertex_start.assign(vertex_count, no_index);
  c.face_count.assign(vertex_count, 0);
  for (Index h = 0; h < c.corners.size(); ++h) {
    if (c.opposite[h] != no_index && c.opposite[h] < h) {
      c.edge[h] = c.edge[c.opposite[h]];
    } else {
      c.edge[h] = static_cast<Index>(c.edge_start.size());
      c.edge_start.push_back(h);
    }
    const Index v = c.corners[h];
    if (c.vertex_start[v] == no_index || c.opposite[h] == no_index) c.vertex_start[v] = h;
    ++c.face_count[v];
  }
  return c;
}

}  // namespace gpsrecon
