#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <span>

namespace gpsrecon::internal {

/// How far a surface is from the one that points were measured on, without knowing that one.
struct HeldOutError {
  double mean_square = 0;     ///< of the offset of the surface, unbiased, so it may be negative
  double standard_error = 0;  ///< of mean_square
  std::size_t pairs = 0;

  /// Root mean square offset, one standard error on the safe side: no less than what the points can resolve.
  double bound() const;
};

/// Points that had no part in making the surface lie off it by the error of the surface and by their noise. Noise is
/// independent from point to point, so the product of the offsets of two points next to each other has the squared
/// error as its mean, whatever the noise. Each point is paired with the one whose foot on the surface, on the same
/// side, is nearest to its own: not the nearest in space, whose noise would be alike. A point farther
/// out than seven times the median offset does not count if most around it are not: then it is an outlier, else the
/// surface is wrong there. Points beyond a rim count with their distance. Blind to what the points share (bias of the
/// scanner, registration), to detail finer than the distance of a pair, and to surface where there are no points.
/// Positions in the frame of the mesh. O(n log n). Throws InvariantError as SurfaceDistance, Cancelled.
HeldOutError held_out_error(const Mesh& mesh, std::span<const Vec3> points, const RunContext& context = {});

}  // namespace gpsrecon::internal
