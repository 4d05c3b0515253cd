#include "datasets/shapes.h"

#include <gpsrecon/core/error.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gpsrecon::datasets {
namespace {

/// The half-plane through an axis and a point, in which the profiles of turned surfaces live. As every profile keeps to
/// ρ >= 0, the closest point of the swept surface lies in the half-plane of the point itself.
struct Meridian {
  Vec3 axis;
  Vec3 radial;
  Vec2 at;

  Meridian(const Vec3& unit_axis, const Vec3& p) : axis(unit_axis) {
    const double height = p.dot(axis);
    const Vec3 across = p - height * axis;
    const double rho = across.norm();
    radial = rho > 0 ? Vec3(across / rho) : axis.unitOrthogonal();
    at = {rho, height};
  }
  Vec3 lift(const Vec2& v) const { return v.x() * radial + v.y() * axis; }
};

SurfacePoint lift(const Meridian& meridian, const ProfilePoint& q) {
  const double distance = std::sqrt(q.squared_distance);
  return {meridian.lift(q.point), meridian.lift(q.normal), q.outside ? distance : -distance};
}

bool on_axis(const Vec2& p) {
  return p.x() == 0;
}

Vec2 mirrored(const Vec2& normal) {
  return {-normal.x(), normal.y()};
}

}  // namespace

Vec3 Solid::gradient(const Vec3& p) const {
  const SurfacePoint q = closest(p);
  // So close to the surface p - q is mostly rounding.
  if (std::abs(q.distance) < 1e-9 * bounding_radius()) return q.normal;
  return (p - q.point) / q.distance;
}

SurfacePoint Cuboid::closest(const Vec3& p) const {
  const Vec3 beyond = p.cwiseAbs() - half_;
  if (beyond.maxCoeff() > 0) {
    const Vec3 q = p.cwiseMax(-half_).cwiseMin(half_);
    Vec3 normal = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
      if (beyond[k] >= 0) normal[k] = std::copysign(1.0, p[k]);
    return {q, normal.normalized(), (p - q).norm()};
  }
  int nearest = 0;
  const double distance = beyond.maxCoeff(&nearest);
  Vec3 q = p;
  q[nearest] = std::copysign(half_[nearest], p[nearest]);
  Vec3 normal = Vec3::Zero();
  normal[nearest] = std::copysign(1.0, p[nearest]);
  return {q, normal, distance};
}

Lathe::Lathe(Profile outline) : outline_(std::move(outline)) {
  if (outline_.start() == outline_.end()) {
    const Vec2 first = outline_.start_normal();
    outline_.join_start(outline_.end_normal());
    outline_.join_end(first);
  } else if (on_axis(outline_.start()) && on_axis(outline_.end())) {
    outline_.join_start(mirrored(outline_.start_normal()));
    outline_.join_end(mirrored(outline_.end_normal()));
  } else {
    throw OptionError("the outline of a turned solid neither closes nor ends on the axis");
  }
  const Profile::Box box = outline_.box();
  bounding_radius_ = std::hypot(box.max.x(), std::max(std::abs(box.min.y()), std::abs(box.max.y())));
}

SurfacePoint Lathe::closest(const Vec3& p) const {
  const Meridian meridian(Vec3::UnitZ(), p);
  return lift(meridian, outline_.closest(meridian.at));
}

Lathe make_sphere(double radius) {
  return Lathe(Profile({0, -radius}).arc_left_to({0, radius}, {0, 0}));
}

Lathe make_torus(double major, double minor) {
  const Vec2 center(major, 0), outer(major + minor, 0), inner(major - minor, 0);
  return Lathe(Profile(outer).arc_left_to(inner, center).arc_left_to(outer, center));
}

Lathe make_cylinder(double radius, double half_height) {
  return Lathe(Profile({0, -half_height})
                   .line_to({radius, -half_height})
                   .line_to({radius, half_height})
                   .line_to({0, half_height}));
}

TurnedBall& TurnedBall::add(const Vec3& axis, Profile profile) {
  const Vec3 unit = axis.normalized();
  const auto on_sphere = [this](const Vec2& p) { return std::abs(p.norm() - radius_) < 1e-9 * radius_; };
  if (!on_sphere(profile.start())) throw OptionError("the profile of a feature does not start on the sphere");
  caps_.push_back({unit, profile.start().y() / radius_});
  profile.join_start(profile.start().normalized());
  if (on_axis(profile.end())) {
    profile.join_end(mirrored(profile.end_normal()));
  } else if (on_sphere(profile.end()) && profile.end().y() < 0) {
    caps_.push_back({-unit, -profile.end().y() / radius_});
    profile.join_end(profile.end().normalized());
  } else {
    throw OptionError("the profile of a feature ends neither on the axis nor on the far side of the sphere");
  }
  const Profile::Box box = profile.box();
  const double middle = 0.5 * (box.min.y() + box.max.y());
  const double radius = std::hypot(box.max.x(), 0.5 * (box.max.y() - box.min.y()));
  bounding_radius_ =
      std::max(bounding_radius_, std::hypot(box.max.x(), std::max(std::abs(box.min.y()), std::abs(box.max.y()))));
  features_.push_back({unit, std::move(profile), middle * unit, radius});
  return *this;
}

SurfacePoint TurnedBall::closest(const Vec3& p) const {
  SurfacePoint best{Vec3::Zero(), Vec3::Zero(), std::numeric_limits<double>::infinity()};
  // The rest of the sphere. For a point below a cap its closest point is on the rim, where a feature starts.
  const double length = p.norm();
  const bool below_cap =
      std::any_of(caps_.begin(), caps_.end(), [&](const Cap& cap) { return p.dot(cap.axis) >= cap.cosine * length; });
  if (!below_cap) {
    const Vec3 direction = length > 0 ? Vec3(p / length) : Vec3::UnitX();
    best = {radius_ * direction, direction, length - radius_};
  }
  for (const Feature& feature : features_) {
    if ((p - feature.center).norm() - feature.radius > std::abs(best.distance)) continue;
    const Meridian meridian(feature.axis, p);
    const SurfacePoint q = lift(meridian, feature.profile.closest(meridian.at));
    if (std::abs(q.distance) < std::abs(best.distance)) best = q;
  }
  return best;
}

}  // namespace gpsrecon::datasets
