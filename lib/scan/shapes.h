#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/scan/profile.h>
#include <gpsrecon/scan/scan_target.h>
#include <vector>

// Surfaces whose distance to any point is known exactly, as truth for virtual scans and tests. They are centred on the
// origin and have no unit.

namespace gpsrecon::internal {

/// The point of a surface that is closest to another point p.
struct ShapePoint {
  Vec3 point;
  Vec3 normal;      ///< unit, outward; on a crease the mean of both sides
  double distance;  ///< of p from the surface, negative inside; never negative where the surface is open
};

class Shape : public ScanTarget {
 public:
  /// Exact up to rounding; where several points are closest, one of them.
  virtual ShapePoint closest(const Vec3& p) const = 0;
  /// Whether it bounds a solid.
  virtual bool is_closed() const { return true; }

  /// Triangles with all vertices on the surface, creases among their edges, so that no point of the mesh is farther
  /// than `tolerance` > 0 (in units of the shape, below a tenth of its radius) from the surface, nor the other way
  /// round. Oriented outward, manifold, closed where the shape is. O(triangles).
  virtual Mesh mesh(double tolerance) const = 0;

  /// A lower bound of the distance that is zero on the surface only; what costs less than the distance serves as well.
  virtual double clearance(const Vec3& p) const;

  double distance(const Vec3& p) const { return closest(p).distance; }
  /// Gradient of the distance, of length 1; on the surface its outward normal.
  Vec3 gradient(const Vec3& p) const;

  /// By sphere tracing: the clearance is how far one may safely go. Rays are followed until they are within 1e-10
  /// bounding radii of the surface; one that grazes it for 400 steps misses.
  std::optional<SurfaceHit> first_hit(const Vec3& origin, const Vec3& direction) const override;
  Vec3 center() const override { return Vec3::Zero(); }
};

/// The box [-h, h] of half extents h > 0.
class Cuboid final : public Shape {
 public:
  explicit Cuboid(const Vec3& half_extents) : half_(half_extents) {}
  ShapePoint closest(const Vec3& p) const override;
  Mesh mesh(double tolerance) const override;
  double bounding_radius() const override { return half_.norm(); }
  double diagonal() const override { return 2 * half_.norm(); }

 private:
  Vec3 half_;
};

/// The box [-h, h] with all edges rounded by a radius 0 < r < min h.
class RoundedBox final : public Shape {
 public:
  /// Throws OptionError if the radius is out of range.
  RoundedBox(const Vec3& half_extents, double radius);
  ShapePoint closest(const Vec3& p) const override;
  Mesh mesh(double tolerance) const override;
  double bounding_radius() const override { return core_.norm() + radius_; }
  double diagonal() const override { return 2 * (core_.array() + radius_).matrix().norm(); }

 private:
  Vec3 core_;  ///< half extents of the box of which this is the offset surface
  double radius_;
};

/// A surface of revolution around the z axis. An outline that closes, or runs upwards from the axis to the axis, bounds
/// a solid; any other, with one end or none on the axis, makes an open surface, oriented to the right of the outline.
class Lathe final : public Shape {
 public:
  explicit Lathe(Profile outline);
  ShapePoint closest(const Vec3& p) const override;
  bool is_closed() const override { return closed_; }
  Mesh mesh(double tolerance) const override;
  double bounding_radius() const override { return bounding_radius_; }
  double diagonal() const override { return diagonal_; }

 private:
  Profile outline_;
  bool closed_;
  double bounding_radius_, diagonal_;
};

Lathe make_sphere(double radius);
/// Around the z axis; 0 < minor < major.
Lathe make_torus(double major, double minor);
/// Around the z axis, |z| <= half_height.
Lathe make_cylinder(double radius, double half_height);

/// The solid over a plane region, |z| <= half_height. The outlines bound the region: closed, disjoint, the outer ones
/// counter-clockwise and holes clockwise.
class Prism final : public Shape {
 public:
  /// Throws OptionError if there is no outline or one is not closed.
  Prism(std::vector<Profile> outlines, double half_height);
  ShapePoint closest(const Vec3& p) const override;
  Mesh mesh(double tolerance) const override;
  double bounding_radius() const override { return bounding_radius_; }
  double diagonal() const override { return diagonal_; }

 private:
  std::vector<Profile> outlines_;
  double half_height_, bounding_radius_, diagonal_;
};

/// A tube around the trefoil knot ((2 + cos 3t) cos 2t, (2 + cos 3t) sin 2t, sin 3t). The curve point closest to p is
/// found among the local minima of a sampling by Newton's method.
class Knot final : public Shape {
 public:
  /// Range of the tube's radius: (0, 0.6], where it stays clear of itself. Throws OptionError.
  explicit Knot(double radius);
  ShapePoint closest(const Vec3& p) const override;
  Mesh mesh(double tolerance) const override;
  double clearance(const Vec3& p) const override;
  double bounding_radius() const override { return 3 + radius_; }
  double diagonal() const override { return diagonal_; }

 private:
  double nearest_sample(const Vec3& p) const;

  double radius_, diagonal_;
  std::vector<Vec3> samples_;  ///< of the curve, at equal steps of t
  double longest_step_;        ///< largest arc length between two samples
};

/// A ball with turned features: bosses, knobs, pits, flats and bores, each a profile around its own axis through the
/// centre. Features must not meet each other, neither on the sphere nor elsewhere.
class TurnedBall final : public Shape {
 public:
  explicit TurnedBall(double radius) : radius_(radius), bounding_radius_(radius) {}

  /// Replaces the cap of the sphere around `axis` by the surface that `profile` sweeps: from its start on the sphere to
  /// its end on the axis. A profile that ends on the sphere at the other side (z < 0) makes a through-bore.
  /// Throws OptionError if an end lies elsewhere.
  TurnedBall& add(const Vec3& axis, Profile profile);

  ShapePoint closest(const Vec3& p) const override;
  Mesh mesh(double tolerance) const override;
  double bounding_radius() const override { return bounding_radius_; }
  double diagonal() const override;

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
  bool is_capped(const Vec3& p) const;
  double support(const Vec3& direction) const;

  double radius_, bounding_radius_;
  std::vector<Feature> features_;
  std::vector<Cap> caps_;
};

}  // namespace gpsrecon::internal
