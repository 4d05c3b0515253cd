#pragma once

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/scale.h>
#include <cmath>

namespace gpsrecon::internal {

/// Widths of the kernel for first Gaussians: balls, and such as span the spacing by themselves (Scale::sigma0 and
/// sigma0_local).
inline double isotropic_width(double spacing, double noise) {
  return std::hypot(spacing, noise);
}
inline double local_width(double spacing, double noise) {
  return std::hypot(0.4 * spacing, 1.6 * noise);
}

/// Whether spacing or noise differ from point to point.
bool differs_by_point(const Scale& scale);

/// The same as in scale.h with an index of the points that is at hand.
Scale estimate_scale(const PointCloud& cloud, const Neighbors& index, const ScaleOptions& options = {},
                     const RunContext& context = {});

}  // namespace gpsrecon::internal
