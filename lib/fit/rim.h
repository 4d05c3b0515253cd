#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/fit/residuals.h>

namespace gpsrecon::internal {

/// The rim of a surface: its boundary samples and, for each, the samples before and after it along the boundary.
struct Rim {
  std::vector<Index> sample, previous, next;
  std::vector<Index> position;  ///< per sample of the surface: its index in `sample`, or no_index
};
Rim find_rim(const LimitSurface& surface);

/// The rim ends where the means of the outermost Gaussians lie, half a Gaussian short of the points. Moves the control
/// vertices of the rim outward, in the surface, by the width of the strip of points left beyond it: twice the mean
/// distance of those points, but not more than their number fills at the spacing of the cloud, so that strays do not
/// pull it. Points farther than `thickness` from the surface do not count. Nothing moves if `control.spacing` is 0.
void extend_rim(const LimitSurface& surface, const Rim& rim, const SurfaceSamples& samples,
                const Assignment& assignment, const PointCloud& cloud, double thickness, Mixture& control);

}  // namespace gpsrecon::internal
