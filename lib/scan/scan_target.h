#pragma once

#include <gpsrecon/core/vec.h>
#include <optional>

namespace gpsrecon::internal {

/// Where a ray meets a surface.
struct SurfaceHit {
  Vec3 point;
  Vec3 normal;  ///< unit; outward where the surface is closed
};

/// A surface as a virtual scanner sees it: an analytic shape or a mesh. Lengths in its own units.
class ScanTarget {
 public:
  virtual ~ScanTarget() = default;

  /// The first point of the surface on the ray from `origin` along `direction` (unit), seen from either side.
  /// Precondition: the origin lies outside the bounding ball.
  virtual std::optional<SurfaceHit> first_hit(const Vec3& origin, const Vec3& direction) const = 0;

  /// A ball that contains the surface.
  virtual Vec3 center() const = 0;
  virtual double bounding_radius() const = 0;
  /// Of the axis-aligned bounding box.
  virtual double diagonal() const = 0;
};

}  // namespace gpsrecon::internal
