#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/run_context.h>
#include <optional>
#include <span>
#include <vector>

namespace gpsrecon::internal {

// `connectivity` is that of `faces`, before and after.

/// Turns closed components outward (signed volume), or inward if they are shells inside an odd number of other closed
/// components; open ones towards the sensor if it is known, else away from their centroid, flat ones up (+z, if upright
/// +y, else +x). Returns the number of components turned over. O(n), and O(c n) for c > 1 closed components.
std::size_t orient(const Mixture& vertices, FaceList& faces, Connectivity& connectivity,
                   const std::optional<Vec3>& sensor);

/// Turns over components, closed ones too, whose faces on the whole face away from where their vertices were seen from
/// (Mixture::outward), each by its area: a room that was scanned from inside faces inward. Returns their number. O(n).
std::size_t orient_outward(const Mixture& vertices, FaceList& faces, Connectivity& connectivity);

/// Turns over open components whose normals most of the points around them contradict: each point votes, with its
/// weight, on the vertex nearest to it. `directions` has one vector per point, of any length, that points to the outer
/// side: its normal, or the way to its sensor. Vectors that are zero or not finite do not vote, nor does anyone on
/// closed components. Returns the number of components turned over. O(p log n) for p points and n vertices.
std::size_t orient_by_vote(const Mixture& vertices, FaceList& faces, Connectivity& connectivity,
                           const PointCloud& cloud, std::span<const Vec3> directions, const RunContext& context = {});

}  // namespace gpsrecon::internal
