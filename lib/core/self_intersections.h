#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <span>

namespace gpsrecon::internal {

/// The faces, ascending, that intersect another face elsewhere than in the corners and edges they share by index. Exact
/// predicates on the positions as they are. Polygons are split into fans from their first corner; triangles without
/// area do not count, nor do intersections within a polygon. Meshes need not be manifold. O(n log² n + pairs of
/// overlapping boxes). Throws InvariantError if a corner is out of range or a used position is not finite; Cancelled.
std::vector<Index> self_intersecting_faces(std::span<const Vec3> positions, const FaceList& faces,
                                           const RunContext& context = {});

}  // namespace gpsrecon::internal
