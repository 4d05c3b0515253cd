#pragma once

#include <gpsrecon/core/mesh.h>
#include <vector>

// Internal to lib/gps and lib/fit.

namespace gpsrecon {

/// Half-edges of a manifold, oriented mesh: half-edge h leaves corners[h]. What lies next to it in its face is up to
/// the kind of mesh.
struct Connectivity {
  std::size_t vertex_count = 0;
  std::vector<Index> corners;       ///< per half-edge: the vertex it leaves
  std::vector<Index> opposite;      ///< per half-edge: the other one of its edge, no_index on the boundary
  std::vector<Index> edge;          ///< per half-edge: its undirected edge
  std::vector<Index> edge_start;    ///< per edge: one of its half-edges
  std::vector<Index> vertex_start;  ///< per vertex: a half-edge leaving it, on the boundary the one without opposite,
                                    ///< no_index if no face uses the vertex
  std::vector<Index> face_count;    ///< per vertex: number of faces around it

  std::size_t edge_count() const { return edge_start.size(); }
  Index source(Index h) const { return corners[h]; }
  bool unused(Index v) const { return vertex_start[v] == no_index; }
  /// Precondition: a face uses v.
  bool on_boundary(Index v) const { return opposite[vertex_start[v]] == no_index; }
};

/// Throws InvariantError unless the corners are below vertex_count and the faces manifold and consistently oriented.
/// Edges are numbered by their first half-edge. O(c log c) in the number of corners.
Connectivity connectivity(const FaceList& faces, std::size_t vertex_count);

}  // namespace gpsrecon
