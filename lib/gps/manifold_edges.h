#pragma once

#include <gpsrecon/core/mesh_topology.h>

// Internal to lib/gps.

namespace gpsrecon {

/// The half-edges of faces that can be refined. Throws InvariantError unless the corners are below vertex_count and the
/// faces manifold and consistently oriented. O(c log c) in the number of corners.
HalfEdges manifold_edges(const FaceList& faces, std::size_t vertex_count);

}  // namespace gpsrecon
