#pragma once

#include <gpsrecon/core/vec.h>
#include <vector>

#include "datasets/profile.h"

// Solids whose signed distance is known exactly, as truth for virtual scans and tests. They are centred on the origin
// and have no unit.

namespace gpsrecon::datasets {

/// The point of a surface that is closest to another point p.
struct SurfacePoint {
  Vec3 point;
  Vec3 normal;      ///< unit, outward; on a crease the mean of both sides
  double distance;  ///< of p from the surface, negative inside
};

class Solid {
 public:
  virtual ~Solid() = default;

  /// Exact; where several points are closest, one of them.
  virtual SurfacePoint closest(const Vec3& p) const = 0;
  /// Radius of a ball around the origin that contains the solid.
  virtual double bounding_radius() const = 0;

  double distance(const Vec3& p) const { return closest(p).distance; }
  /// Gradient of the signed distance, of length 1; on the surface its outward normal.
  Vec3 gradient(const Vec3& p) const;
};

/// The box [-h, h] of half extents h > 0.
class Cuboid final : public Solid {
 public:
  explicit Cuboid(const Vec3& half_extents) : half_(half_extents) {}
  SurfacePoint closest(const Vec3& p) const override;
  double bounding_radius() const override { return half_.norm(); }

 private:
  Vec3 half_;
};

/// A solid of revolution around the z axis. The outline is closed, or runs from the axis to the axis upwards.
class Lathe final : public Solid {
 public:
  /// Throws OptionError if the outline does neither.
  explicit Lathe(Profile outline);
  SurfacePoint closest(const Vec3& p) const override;
  double bounding_radius() const override { return bounding_radius_; }

 private:
  Profile outline_;
  double bounding_radius_;
};

Lathe make_sphere(double radius);
/// Around the z axis; 0 < minor < major.
Lathe make_torus(double major, double minor);
/// Around the z axis, |z| <= half_height.
Lathe make_cylinder(double radius, double half_height);

/// A ball with turned features: bosses, knobs, pits, flats and bores, each a profile around its own axis through the
/// centre. Features must not meet each other, neither on the sphere nor elsewhere.
class TurnedBall final : public Solid {
 public:
  explicit TurnedBall(double radius) : radius_(radius), bounding_radius_(radius) {}

  /// Replaces the cap of the sphere around `axis` by the surface that `profile` sweeps: from its start on the sphere to
  /// its end on the axis. A profile that ends on the sphere at the other side (z < 0) makes a through-bore.
  /// Throws OptionError if an end lies elsewhere.
  TurnedBall& add(const Vec3& axis, Profile profile);

  SurfacePoint closest(const Vec3& p) const override;
  double bounding_radius() const override { return bounding_radius_; }

 private:
  struct Feature {
    Vec3 axis;
    Profile profile;
    Vec3 center;    ///< of a ball around the swept profile
    double radius;  ///< of that ball
  };
  struct Cap {
    Vec3 axis;
    double cosine;  ///< of its angular radius
  };
  double radius_, bounding_radius_;
  std::vector<Feature> features_;
  std::vector<Cap> caps_;
};

}  // namespace gpsrecon::datasets
