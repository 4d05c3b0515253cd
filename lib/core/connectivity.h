#pragma once

#include <gpsrecon/core/mesh.h>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace gpsrecon {

/// How the faces of a mesh hang together: half-edges, undirected edges and the fans of faces around vertices (Kettner
/// 1999, half-edges as flat arrays). Half-edge h is corner h of the face list: it leaves corners[h] and runs to the
/// next corner of the same face. Built once per mesh and handed on, by those who own the mesh. About 16 bytes per
/// half-edge, 8 more if the faces have neither all three nor all four corners, and 8 per vertex.
struct Connectivity {
  std::size_t vertex_count = 0;
  Index corners_per_face = 3;         ///< 3 or 4 if all faces have so many, otherwise 0
  std::vector<Index> corners;         ///< per half-edge: the vertex it leaves
  std::vector<Index> face_of;         ///< per half-edge: its face; empty unless corners_per_face is 0
  std::vector<Index> face_offsets;    ///< per face: its first half-edge, and the end; empty likewise
  std::vector<Index> opposite;        ///< per half-edge: the other one of its edge; no_index on a boundary and on edges
                                      ///< that are not manifold or not consistently oriented
  std::vector<Index> edge;            ///< per half-edge: its undirected edge
  std::vector<Index> edge_start;      ///< per edge: one of its half-edges, the first where build_connectivity() made it
  std::vector<Index> vertex_start;    ///< per vertex: a half-edge that leaves it, on a boundary one without opposite,
                                      ///< no_index if no face uses the vertex
  std::vector<Index> face_count;      ///< per vertex: number of faces around it
  std::size_t nonmanifold_edges = 0;  ///< edges of more than two half-edges
  std::size_t inconsistent_edges = 0;   ///< edges of two half-edges in the same direction
  Index first_nonmanifold = no_index;   ///< the first half-edge of the first such edge, by its two vertices
  Index first_inconsistent = no_index;  ///< likewise

  std::size_t half_edge_count() const { return corners.size(); }
  std::size_t edge_count() const { return edge_start.size(); }
  std::size_t face_total() const {
    return corners_per_face != 0 ? corners.size() / corners_per_face : face_offsets.size() - 1;
  }

  Index face(Index h) const { return corners_per_face == 3 ? h / 3 : corners_per_face == 4 ? h / 4 : face_of[h]; }
  Index face_start(Index f) const { return corners_per_face != 0 ? corners_per_face * f : face_offsets[f]; }
  Index face_size(Index f) const { return face_start(f + 1) - face_start(f); }
  Index next(Index h) const {
    if (corners_per_face == 3) return h % 3 == 2 ? h - 2 : h + 1;
    if (corners_per_face == 4) return h % 4 == 3 ? h - 3 : h + 1;
    return h + 1 == face_offsets[face_of[h] + 1] ? face_offsets[face_of[h]] : h + 1;
  }
  Index previous(Index h) const {
    if (corners_per_face == 3) return h % 3 == 0 ? h + 2 : h - 1;
    if (corners_per_face == 4) return h % 4 == 0 ? h + 3 : h - 1;
    return h == face_offsets[face_of[h]] ? face_offsets[face_of[h] + 1] - 1 : h - 1;
  }
  Index source(Index h) const { return corners[h]; }
  Index target(Index h) const { return corners[next(h)]; }

  bool unused(Index v) const { return vertex_start[v] == no_index; }
  /// Precondition: a face uses v.
  bool on_boundary(Index v) const { return opposite[vertex_start[v]] == no_index; }

  /// Calls visit(g) for the half-edges that leave the start of h, h first, then counter-clockwise from face to face to
  /// the boundary or back to h. Returns the half-edge that arrives along that boundary, or no_index.
  template <class Visit>
  Index for_each_in_fan(Index h, const Visit& visit) const {
    Index g = h;
    do {
      visit(g);
      const Index arriving = previous(g);
      g = opposite[arriving];
      if (g == no_index) return arriving;
    } while (g != h);
    return no_index;
  }
  /// The same for the half-edges that leave v, which is to have one fan. Precondition: a face uses v.
  template <class Visit>
  Index for_each_leaving(Index v, const Visit& visit) const {
    return for_each_in_fan(vertex_start[v], visit);
  }
  /// Calls visit(h, arriving) for a half-edge of every edge at v counter-clockwise: of those that leave v, and on the
  /// boundary of the last that arrives there. Not at all where no face uses v.
  template <class Visit>
  void for_each_edge(Index v, const Visit& visit) const {
    if (unused(v)) return;
    const Index arriving = for_each_leaving(v, [&](Index h) { visit(h, false); });
    if (arriving != no_index) visit(arriving, true);
  }
  /// Calls visit(r) for the neighbours of v counter-clockwise: face_count[v] of them in the interior, one more on the
  /// boundary, from the target of the leaving boundary edge to the source of the arriving one.
  template <class Visit>
  void for_each_neighbor(Index v, const Visit& visit) const {
    for_each_edge(v, [&](Index h, bool arriving) { visit(arriving ? source(h) : target(h)); });
  }
};

/// The connectivity of any polygons. Edges are numbered by their first half-edge. O(n) in the corners and vertices.
/// Throws InvariantError if a corner is not below vertex_count.
Connectivity build_connectivity(const FaceList& faces, std::size_t vertex_count);

/// The same, and throws InvariantError, its text after `what`, unless the faces are manifold and consistently oriented.
Connectivity manifold_connectivity(const FaceList& faces, std::size_t vertex_count, const char* what = "mesh");

/// The connectivity of a covariance mesh. Throws InvariantError as validate(mesh). O(n).
Connectivity validated_connectivity(const CovMesh& mesh);

/// A valid covariance mesh with its connectivity, as the stages take it: where it is at hand it is handed on, and a
/// mesh alone is checked and connected.
struct ConnectedMesh {
  CovMesh mesh;
  Connectivity connectivity;

  /// By validated_connectivity(); implicit, so that a mesh will do.
  ConnectedMesh(CovMesh covmesh)  // NOLINT(google-explicit-constructor)
      : mesh(std::move(covmesh)), connectivity(validated_connectivity(mesh)) {}
  /// Precondition: the connectivity is that of the mesh, which is valid.
  ConnectedMesh(CovMesh covmesh, Connectivity known) : mesh(std::move(covmesh)), connectivity(std::move(known)) {}
};

/// The same half-edges and edges over other vertices: where fans that touched have been parted, or vertices renumbered.
/// Corners that an edge joins must have the same vertex as before each other. O(n), without matching half-edges again.
Connectivity over_vertices(Connectivity connectivity, std::vector<Index> corners, std::size_t vertex_count);

/// The faces again. O(n).
FaceList face_list(const Connectivity& connectivity);

/// The edges at every vertex, ascending: those of vertex v are edges[offsets[v] .. offsets[v + 1]).
struct VertexEdges {
  std::vector<Index> offsets, edges;

  std::span<const Index> operator[](Index v) const {
    return {edges.data() + offsets[v], edges.data() + offsets[v + 1]};
  }
};
/// O(n).
VertexEdges vertex_edges(const Connectivity& connectivity);

}  // namespace gpsrecon
