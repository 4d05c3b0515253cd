#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/run_context.h>
#include <vector>

namespace gpsrecon::internal {

/// How much of the sky each component of a mixture sees past the others, on either side of the sheet it lies in.
struct Exposure {
  std::vector<Vec3> axis;  ///< unit normal of the sheet, of either sign: the axis of the smallest variance
  /// Share of the light of an evenly bright sky that reaches the component on the side of the axis, and on the other
  /// side. In [0, 1]; one is many times the other on closed surfaces, they are equal on flat sheets alone.
  std::vector<double> front, back;
  /// Mean direction the light comes from, that of the opposite directions subtracted: the bent normal of ambient
  /// occlusion. At most 1 long; on closed surfaces it points outward, on creases and tips too.
  std::vector<Vec3> bent_normal;
};

/// Light from 64 directions spread evenly over the sphere passes through the components, each of which absorbs by its
/// density (Max 1995, absorption only), so scaled that a sheet lets exp(-3) through at right angles, however its
/// points are spread. Half of a sheet's own density lies on either side of it and treats both alike, so two sheets need
/// only be apart by more than their thickness to shade each other. O(n k) for k components along a ray, the same bits
/// for any number of threads. Throws Cancelled.
Exposure exposure(const Mixture& mixture, const RunContext& context = {});

}  // namespace gpsrecon::internal
