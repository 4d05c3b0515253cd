#pragma once

#include <gpsrecon/triangulate/growing_surface.h>
#include <gpsrecon/triangulate/overlap_graph.h>

namespace gpsrecon::internal {

/// Finds patches of the surface that show their inner side: where a front turned back in a crumpled region and grew on
/// inside out, it ends along a seam at which overlapping, parallel Gaussians face opposite ways. The sheet normals are
/// given consistent signs along a maximum spanning forest of their overlaps (Hoppe et al. 1992, over Gaussians);
/// patches that disagree with the rest of their tree, and hang on the surface by fewer than half as many edges as they
/// are open along, are turned over and parted from it there. Returns the number of triangles turned. O(n k log n).
std::size_t turn_inside_out(GrowingSurface& surface, const OverlapGraph& graph, const std::vector<Vec3>& sheet_normals);

}  // namespace gpsrecon::internal
