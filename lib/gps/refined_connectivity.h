#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/run_context.h>

// Internal to lib/gps: the connectivity of a refined mesh in closed form, without matching half-edges again. Vertices
// of the parent keep their number and the vertex on edge e is vertex_count + e, with either scheme. Precondition of
// all: the parent is manifold and consistently oriented.

namespace gpsrecon::internal {

/// Throws InvariantError unless all faces are triangles.
void check_triangles(const Connectivity& connectivity);
/// Throws InvariantError unless the faces are triangles, manifold and consistently oriented. O(n).
Connectivity triangle_connectivity(const FaceList& faces, std::size_t vertex_count);

/// One triangle to four (Loop 1987). Face f with corners a, b, c becomes 4f: (a, ab, ca), 4f + 1: (b, bc, ab),
/// 4f + 2: (c, ca, bc), 4f + 3: (ab, bc, ca). O(n). Precondition: triangles.
Connectivity refine_triangles(const Connectivity& parent, const RunContext& context = {});
/// The faces of refine_triangles(parent) alone. O(n).
FaceList refined_triangles(const Connectivity& parent, const RunContext& context = {});

/// One quadrilateral per corner of any polygons (Catmull and Clark 1978): half-edge h becomes quadrilateral h, (its
/// source, its edge, its face, the edge before). After the vertices on the edges come those in the faces. O(n).
Connectivity refine_to_quads(const Connectivity& parent, const RunContext& context = {});
/// The faces of refine_to_quads(parent) alone. O(n).
FaceList refined_quads(const Connectivity& parent, const RunContext& context = {});

}  // namespace gpsrecon::internal
