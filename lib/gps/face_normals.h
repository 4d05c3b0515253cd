#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>

// Internal to lib/gps.

namespace gpsrecon::internal {

/// Replaces normals that are zero by those of the faces around, weighted by area; they stay zero where these cancel or
/// no face uses the vertex. Returns the vertices whose normals were zero, ascending. O(n).
std::vector<Index> complete_normals(const FaceList& faces, const std::vector<Vec3>& positions,
                                    std::vector<Vec3>& normals, const RunContext& context = {});

}  // namespace gpsrecon::internal
