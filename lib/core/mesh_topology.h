#pragma once

#include <gpsrecon/core/mesh.h>
#include <string>
#include <vector>

namespace gpsrecon {

/// Half-edges of a polygon list, flat. Half-edge h starts at corner h of the list (vertex faces.corners[h]) and runs to
/// the next corner of the same face.
struct HalfEdges {
  std::vector<Index> next;             ///< per half-edge: the next one of its face
  std::vector<Index> face;             ///< per half-edge: its face
  std::vector<Index> opposite;         ///< per half-edge: the one in the other direction; no_index on a boundary and on
                                       ///< edges that are not manifold or not consistently oriented
  std::size_t edges = 0;               ///< number of undirected edges
  std::size_t nonmanifold_edges = 0;   ///< undirected edges with more than two half-edges
  std::size_t inconsistent_edges = 0;  ///< undirected edges with two half-edges of the same direction
  Index first_nonmanifold = no_index;  ///< a half-edge of the first such edge, by its vertices
  Index first_inconsistent = no_index;
};

/// O(c log c) in the number of corners c. Precondition: corners < vertex_count.
HalfEdges half_edges(const FaceList& faces, std::size_t vertex_count);

/// Boundary loops as closed vertex sequences, each following the boundary half-edges in their own direction (the
/// surface lies to the left). At a vertex where several loops touch each loop stays within its own fan. Ordered by
/// their first half-edge.
std::vector<std::vector<Index>> boundary_loops(const FaceList& faces, const HalfEdges& half_edges);

/// Labels faces by connected component (joined across edges), 0, 1, ... in order of first appearance.
struct Components {
  std::vector<Index> of_face;
  std::size_t count = 0;
};
Components face_components(const FaceList& faces, const HalfEdges& half_edges);

/// Per vertex, the number of fans (maximal sequences of faces around it joined across edges): 0 unused, 1 manifold.
std::vector<Index> vertex_fans(const FaceList& faces, const HalfEdges& half_edges, std::size_t vertex_count);

/// What keeps faces from being an oriented manifold, in words: how many edges and vertices, and the first of each kind
/// by number; empty if nothing does. O(c).
std::string manifold_faults(const FaceList& faces, const HalfEdges& half_edges, std::size_t vertex_count);

/// Counts that describe a mesh; only vertices used by a face count.
struct Topology {
  std::size_t vertices = 0, unused_vertices = 0, edges = 0, faces = 0;
  std::size_t components = 0, boundary_loops = 0, boundary_edges = 0;
  std::size_t nonmanifold_edges = 0, nonmanifold_vertices = 0, inconsistent_edges = 0;
  long euler = 0;  ///< V - E + F

  bool manifold() const { return nonmanifold_edges == 0 && nonmanifold_vertices == 0 && inconsistent_edges == 0; }
};

/// O(c log c). Throws InvariantError if a corner is out of range.
Topology topology(const FaceList& faces, std::size_t vertex_count);

}  // namespace gpsrecon
