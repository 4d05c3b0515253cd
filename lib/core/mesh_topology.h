#pragma once

#include <gpsrecon/core/connectivity.h>
#include <string>
#include <vector>

namespace gpsrecon {

/// Boundary loops as closed vertex sequences, each following the boundary half-edges in their own direction (the
/// surface lies to the left). At a vertex where several loops touch each loop stays within its own fan. Ordered by
/// their first half-edge.
std::vector<std::vector<Index>> boundary_loops(const Connectivity& connectivity);

/// Labels faces by connected component (joined across edges), 0, 1, ... in order of first appearance.
struct Components {
  std::vector<Index> of_face;
  std::size_t count = 0;
};
Components face_components(const Connectivity& connectivity);

/// Per vertex, the number of fans (maximal sequences of faces around it joined across edges): 0 unused, 1 manifold.
std::vector<Index> vertex_fans(const Connectivity& connectivity);

/// What keeps faces from being an oriented manifold, in words: how many edges and vertices, and the first of each kind
/// by number; empty if nothing does. O(n).
std::string manifold_faults(const Connectivity& connectivity);

/// Counts that describe a mesh; only vertices used by a face count.
struct Topology {
  std::size_t vertices = 0, unused_vertices = 0, edges = 0, faces = 0;
  std::size_t components = 0, boundary_loops = 0, boundary_edges = 0;
  std::size_t nonmanifold_edges = 0, nonmanifold_vertices = 0, inconsistent_edges = 0;
  long euler = 0;  ///< V - E + F

  bool manifold() const { return nonmanifold_edges == 0 && nonmanifold_vertices == 0 && inconsistent_edges == 0; }
};

/// O(n).
Topology topology(const Connectivity& connectivity);
/// The same by build_connectivity().
Topology topology(const FaceList& faces, std::size_t vertex_count);

}  // namespace gpsrecon
