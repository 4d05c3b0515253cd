#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/gps/stencils.h>
#include <gpsrecon/gps/subdivide.h>

// Internal to lib/gps: one step of Catmull and Clark's scheme with half-edges, as the evaluation needs it.

namespace gpsrecon {

/// Half-edges of a manifold, oriented polygon mesh: half-edge h leaves corners[h].
struct PolygonEdges {
  std::size_t vertex_count = 0;
  std::vector<Index> corners, opposite, next, previous;
  std::vector<Index> start;       ///< per vertex: a half-edge leaving it, on the boundary the one without opposite
  std::vector<Index> face_count;  ///< per vertex

  bool unused(Index v) const { return start[v] == no_index; }
  bool on_boundary(Index v) const { return opposite[start[v]] == no_index; }
  Index target(Index h) const { return corners[next[h]]; }
};

/// Throws InvariantError unless the faces are manifold and consistently oriented.
PolygonEdges polygon_edges(const FaceList& faces, std::size_t vertex_count);

/// The refined mesh, quad h for half-edge h of the old one: (its source, its edge, its face, the edge before it).
/// Vertices are the old ones, one per edge, one per face.
struct QuadStep {
  PolygonEdges edges;
  StencilTable stencils;
};
QuadStep catmull_clark_step(const PolygonEdges& edges, CornerRule corners);

/// Limit positions and tangents at the vertices of a mesh of quadrilaterals, in the manner of limit_table: interior
/// n/(n + 5), 4/(n(n + 5)), 1/(n(n + 5)) and the dominant left eigenvectors of the fan; on the boundary the cubic
/// B-spline, the tangent along it and the dominant mode across.
LimitTable quad_limit_table(const PolygonEdges& quads, CornerRule corners);

}  // namespace gpsrecon
