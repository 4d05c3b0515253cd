#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/triangulate/growing_surface.h>
#include <gpsrecon/triangulate/overlap_graph.h>
#include <gpsrecon/triangulate/triangulate.h>

namespace gpsrecon::internal {

/// Flips interior edges as long as that raises the grade of the surface, Σ ln BC + ln(β/π) over its edges, β the
/// dihedral angle at each (π without a second triangle). An edge is flipped only to another pair that overlaps, if both
/// triangles stay on the side of the two before (nothing folds, and they cover what those did), no angle falls below
/// options.min_dihedral, and no vertex loses its third edge. Each flip raises the grade, so it ends; in the order of
/// the triangles, so it is deterministic. Returns the number of flips.
std::size_t flip_edges(GrowingSurface& surface, const OverlapGraph& graph, const TriangulateOptions& options);

}  // namespace gpsrecon::internal
