#pragma once

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/run_context.h>
#include <span>
#include <vector>

namespace gpsrecon::internal {

/// Spacing and noise at every point, smooth over space. Lengths in the units of the positions.
struct LocalScale {
  std::vector<double> spacing;  ///< side of the area per point, where points repeat or stand in lines that between them
  std::vector<double> noise;    ///< standard deviation of the points across the surface
};

/// Measures around a regular subset of the points. The noise is the residual of the quadric of least squares, so that
/// curvature is none, through the smallest neighbourhood that the sheet of the points is thin in, and that is no layer
/// of a thicker one: where noise is larger than the spacing, a small ball holds too few of the points across the
/// surface. Of thin walls, the points of one of their sheets. The spacing comes from how far places between points are
/// from the nearest one, wherever that is more than the distance to the 8th neighbour tells: repeated points and scan
/// lines are dense along themselves only. `by_neighbors` is the spacing that this one tells, per point; `sensors` are
/// where the points were seen from, or empty: a sheet behind another one, as seen from there, is noise. Samples that
/// show no surface have the noise that is usual in the cloud. O(n log n). Precondition: three points at least.
LocalScale estimate_local_scale(std::span<const Vec3> points, std::span<const Vec3> sensors, const Neighbors& index,
                                std::span<const double> by_neighbors, const RunContext& context);

}  // namespace gpsrecon::internal
