#pragma once

#include <gpsrecon/gps/evaluate.h>

// Internal to lib/gps.

namespace gpsrecon::internal {

/// Where the vertices of a refinement lie on the limit surface: of each the parameter as the first face that uses it
/// sees it. `refined` are the faces after `levels` steps from `control` as loop_refine or catmull_clark_refine number
/// them. Vertices without faces have the patch no_index. O(size of the refinement).
std::vector<SurfaceParameter> refined_parameters(const FaceList& control, const FaceList& refined,
                                                 std::size_t vertex_count, int levels, Scheme scheme);

}  // namespace gpsrecon::internal
