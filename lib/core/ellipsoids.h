#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/options.h>

namespace gpsrecon::internal {

struct EllipsoidOptions {
  double scale = 1;
  int level = 1;
  bool colors = true;

  static OptionTable fields() {
    using O = EllipsoidOptions;
    return {
        field<&O::scale>("ellipsoid-scale", "> 0", "half axes of the ellipsoids").in("standard deviations"),
        field<&O::level>("ellipsoid-level", "[0, 5]", "refinements of an icosahedron, level L has 20 * 4^L triangles")
            .only_in_library(),
        field<&O::colors>("ellipsoid-colors", "",
                          "colour by the direction of the smallest axis, the surface normal of a flat Gaussian")
            .only_in_library()};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// A mixture to look at: every Gaussian as a closed triangle mesh μ + scale Σ^(1/2) u with vertices u on the unit
/// sphere, facing outward. All vertices lie on the surface of Mahalanobis distance `scale`. In the frame of the
/// mixture. O(n 4^level). Throws OptionError.
Mesh ellipsoid_mesh(const Mixture& mixture, const EllipsoidOptions& options = {});

}  // namespace gpsrecon::internal
