#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mixture.h>

namespace gpsrecon {

struct EllipsoidOptions {
  /// Half axes in standard deviations. Range: > 0.
  double scale = 1;
  /// Refinements of an icosahedron, level L has 20 * 4^L triangles. Range: [0, 5].
  int level = 1;
  /// Colour by the direction of the smallest axis, the surface normal of a flat Gaussian.
  bool colors = true;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// A mixture to look at: every Gaussian as a closed triangle mesh μ + scale Σ^(1/2) u with vertices u on the unit
/// sphere, facing outward. All vertices lie on the surface of Mahalanobis distance `scale`. In the frame of the
/// mixture. O(n 4^level). Throws OptionError.
Mesh ellipsoid_mesh(const Mixture& mixture, const EllipsoidOptions& options = {});

}  // namespace gpsrecon
