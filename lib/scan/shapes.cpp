#include "shapes.h"

#include <gpsrecon/core/error.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "shape_meshing.h"

namespace gpsrecon::internal {
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

ShapePoint lift(const Meridian& meridian, const ProfilePoint& q) {
  const double distance = std::sqrt(q.squared_distance);
  return {meridian.lift(q.point), meridian.lift(q.normal), q.outside ? distance : -distance};
}

bool on_axis(const Vec2& p) {
  return p.x() == 0;
}

Vec2 mirrored(const Vec2& normal) {
  return {-normal.x(), normal.y()};
}

/// Lets the two ends of a closed outline know of each other.
void join_ends(Profile& outline) {
  const Vec2 first = outline.start_normal();
  outline.join_start(outline.end_normal());
  outline.join_end(first);
}

/// Number of vertices around the axis of a turned profile.
std::size_t around(const Profile& profile, double tolerance) {
  return std::max<std::size_t>(3, chords(profile.box().max().x(), 2 * std::numbers::pi, tolerance));
}

}  // namespace

double Shape::clearance(const Vec3& p) const {
  return std::abs(closest(p).distance);
}

std::optional<SurfaceHit> Shape::first_hit(const Vec3& origin, const Vec3& direction) const {
  constexpr int max_steps = 400;  // only rays that graze the surface need more
  const double radius = bounding_radius();
  const double middle = -origin.dot(direction);
  const double squared_half_chord = radius * radius - (origin + middle * direction).squaredNorm();
  if (squared_half_chord <= 0) return std::nullopt;
  const double half_chord = std::sqrt(squared_half_chord);
  double t = std::max(0.0, middle - half_chord);
  for (int step = 0; step < max_steps && t <= middle + half_chord; ++step) {
    const Vec3 p = origin + t * direction;
    const double free = clearance(p);
    if (free <= 1e-10 * radius) {
      const ShapePoint q = closest(p);
      return SurfaceHit{q.point, q.normal};
    }
    t += free;
  }
  return std::nullopt;
}

Vec3 Shape::gradient(const Vec3& p) const {
  const ShapePoint q = closest(p);
  // So close to the surface p - q is mostly rounding.
  if (std::abs(q.distance) < 1e-9 * bounding_radius()) return q.normal;
  return (p - q.point) / q.distance;
}

Mesh Cuboid::mesh(double) const {
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.positions.push_back(
        half_.cwiseProduct(Vec3((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1)));
  add_quad(mesh, 0, 2, 3, 1);
  add_quad(mesh, 4, 5, 7, 6);
  add_quad(mesh, 0, 1, 5, 4);
  add_quad(mesh, 2, 6, 7, 3);
  add_quad(mesh, 0, 4, 6, 2);
  add_quad(mesh, 1, 3, 7, 5);
  return mesh;
}

ShapePoint Cuboid::closest(const Vec3& p) const {
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

RoundedBox::RoundedBox(const Vec3& half_extents, double radius)
    : core_(half_extents.array() - radius), radius_(radius) {
  if (!(radius > 0 && core_.minCoeff() > 0)) throw OptionError("a box is too small for the radius of its edges");
}

ShapePoint RoundedBox::closest(const Vec3& p) const {
  const Vec3 q = p.cwiseMax(-core_).cwiseMin(core_);
  if (q != p) {
    const Vec3 normal = (p - q).normalized();
    return {q + radius_ * normal, normal, (p - q).norm() - radius_};
  }
  int nearest = 0;
  const double distance = (p.cwiseAbs() - core_).maxCoeff(&nearest) - radius_;
  const Vec3 normal = std::copysign(1.0, p[nearest]) * Vec3::Unit(nearest);
  return {p - distance * normal, normal, distance};
}

/// A sphere of parallels and meridians, pulled apart along the three planes between its octants; the poles become
/// rectangles.
Mesh RoundedBox::mesh(double tolerance) const {
  const std::size_t n = chords(radius_, std::numbers::pi / 2, tolerance / 2);
  const auto angle = [n](std::size_t quadrant, std::size_t step) {
    return (static_cast<double>(quadrant) + static_cast<double>(step) / static_cast<double>(n)) * std::numbers::pi / 2;
  };
  Mesh mesh;
  std::vector<Ring> rows;
  for (std::size_t half = 0; half < 2; ++half)
    for (std::size_t i = 0; i <= n; ++i) {
      const bool pole = i == (half == 0 ? 0 : n);
      const double latitude = angle(half, i) - std::numbers::pi / 2;
      Ring row;
      for (std::size_t quadrant = 0; quadrant < 4; ++quadrant)
        for (std::size_t j = 0; j <= n; ++j) {
          if (!pole || j == 0) {
            const Vec3 corner =
                core_.cwiseProduct(Vec3(quadrant % 3 == 0 ? 1 : -1, quadrant < 2 ? 1 : -1, half == 0 ? -1 : 1));
            const double ring = pole ? 0 : std::cos(latitude), longitude = angle(quadrant, j);
            mesh.positions.push_back(
                corner + radius_ * Vec3(ring * std::cos(longitude), ring * std::sin(longitude), std::sin(latitude)));
          }
          row.push_back(static_cast<Index>(mesh.positions.size() - 1));
        }
      rows.push_back(std::move(row));
    }
  for (std::size_t i = 0; i + 1 < rows.size(); ++i)
    for (std::size_t j = 0; j < rows[i].size(); ++j) {
      const std::size_t next = (j + 1) % rows[i].size();
      add_quad(mesh, rows[i][j], rows[i][next], rows[i + 1][next], rows[i + 1][j]);
    }
  const auto corner = [n](const Ring& pole, std::size_t quadrant) { return pole[quadrant * (n + 1)]; };
  const Ring &south = rows.front(), &north = rows.back();
  add_quad(mesh, corner(south, 3), corner(south, 2), corner(south, 1), corner(south, 0));
  add_quad(mesh, corner(north, 0), corner(north, 1), corner(north, 2), corner(north, 3));
  return mesh;
}

Lathe::Lathe(Profile outline) : outline_(std::move(outline)) {
  const bool starts_on_axis = on_axis(outline_.start()), ends_on_axis = on_axis(outline_.end());
  closed_ = outline_.is_closed() || (starts_on_axis && ends_on_axis);
  if (outline_.is_closed()) {
    join_ends(outline_);
  } else {
    if (starts_on_axis) outline_.join_start(mirrored(outline_.start_normal()));
    if (ends_on_axis) outline_.join_end(mirrored(outline_.end_normal()));
  }
  const Eigen::AlignedBox2d box = outline_.box();
  diagonal_ = Vec3(2 * box.max().x(), 2 * box.max().x(), box.max().y() - box.min().y()).norm();
  bounding_radius_ = std::hypot(box.max().x(), std::max(std::abs(box.min().y()), std::abs(box.max().y())));
}

ShapePoint Lathe::closest(const Vec3& p) const {
  const Meridian meridian(Vec3::UnitZ(), p);
  ShapePoint q = lift(meridian, outline_.closest(meridian.at));
  if (!closed_) q.distance = std::abs(q.distance);
  return q;
}

Mesh Lathe::mesh(double tolerance) const {
  Mesh mesh;
  sweep(mesh, outline_.sample(tolerance / 2), Vec3::UnitZ(), around(outline_, tolerance / 2));
  return mesh;
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

Prism::Prism(std::vector<Profile> outlines, double half_height)
    : outlines_(std::move(outlines)), half_height_(half_height) {
  if (outlines_.empty()) throw OptionError("a prism has no outline");
  Eigen::AlignedBox2d box;
  for (Profile& outline : outlines_) {
    if (!outline.is_closed()) throw OptionError("the outline of a prism does not close");
    join_ends(outline);
    box.extend(outline.box());
  }
  diagonal_ = std::hypot(box.diagonal().norm(), 2 * half_height);
  bounding_radius_ = std::hypot(box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm(), half_height);
}

ShapePoint Prism::closest(const Vec3& p) const {
  const Vec2 at = p.head<2>();
  ProfilePoint wall = outlines_.front().closest(at);
  for (std::size_t i = 1; i < outlines_.size(); ++i)
    if (const ProfilePoint q = outlines_[i].closest(at); q.squared_distance < wall.squared_distance) wall = q;
  const double beside = wall.outside ? std::sqrt(wall.squared_distance) : -std::sqrt(wall.squared_distance);
  const double above = std::abs(p.z()) - half_height_;
  const Vec3 up(0, 0, std::copysign(1.0, p.z())), outward(wall.normal.x(), wall.normal.y(), 0);
  const Vec3 foot(wall.point.x(), wall.point.y(), p.z());
  if (above >= 0 && beside >= 0) return {foot - above * up, (outward + up).normalized(), std::hypot(above, beside)};
  if (above >= beside) return {p - above * up, up, above};
  return {foot, outward, beside};
}

Mesh Prism::mesh(double tolerance) const {
  std::vector<Vec2> points;
  std::vector<std::vector<Index>> polygons;
  for (const Profile& outline : outlines_) {
    std::vector<Vec2> chain = outline.sample(tolerance);
    chain.pop_back();  // the start again
    polygons.emplace_back();
    for (const Vec2& p : chain) {
      polygons.back().push_back(static_cast<Index>(points.size()));
      points.push_back(p);
    }
  }
  const auto n = static_cast<Index>(points.size());
  Mesh mesh;
  for (const double z : {half_height_, -half_height_})
    for (const Vec2& p : points) mesh.positions.emplace_back(p.x(), p.y(), z);
  for (const auto& [a, b, c] : triangulate_region(points, polygons)) {
    mesh.faces.add(a, b, c);
    mesh.faces.add(n + a, n + c, n + b);
  }
  for (const std::vector<Index>& polygon : polygons)
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Index a = polygon[k], b = polygon[(k + 1) % polygon.size()];
      add_quad(mesh, n + a, n + b, b, a);
    }
  return mesh;
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
  const Eigen::AlignedBox2d box = profile.box();
  const double middle = 0.5 * (box.min().y() + box.max().y());
  const double radius = std::hypot(box.max().x(), 0.5 * (box.max().y() - box.min().y()));
  bounding_radius_ =
      std::max(bounding_radius_, std::hypot(box.max().x(), std::max(std::abs(box.min().y()), std::abs(box.max().y()))));
  features_.push_back({unit, std::move(profile), middle * unit, radius});
  return *this;
}

/// Whether the point of the sphere below p has given way to a feature.
bool TurnedBall::is_capped(const Vec3& p) const {
  const double length = p.norm();
  return std::any_of(caps_.begin(), caps_.end(),
                     [&](const Cap& cap) { return p.dot(cap.axis) >= cap.cosine * length; });
}

/// Largest value of q · direction over the surface. What a feature does not reach the sphere does, or the rim of a cap,
/// where a feature starts.
double TurnedBall::support(const Vec3& direction) const {
  double support = is_capped(direction) ? 0 : radius_;
  for (const Feature& feature : features_) {
    const double along = direction.dot(feature.axis);
    support = std::max(support, feature.profile.support({std::sqrt(std::max(0.0, 1 - along * along)), along}));
  }
  return support;
}

double TurnedBall::diagonal() const {
  Vec3 extent;
  for (int k = 0; k < 3; ++k) extent[k] = support(Vec3::Unit(k)) + support(-Vec3::Unit(k));
  return extent.norm();
}

ShapePoint TurnedBall::closest(const Vec3& p) const {
  ShapePoint best{Vec3::Zero(), Vec3::Zero(), std::numeric_limits<double>::infinity()};
  // The rest of the sphere. For a point below a cap its closest point is on the rim, where a feature starts.
  if (!is_capped(p)) {
    const double length = p.norm();
    const Vec3 direction = length > 0 ? Vec3(p / length) : Vec3::UnitX();
    best = {radius_ * direction, direction, length - radius_};
  }
  for (const Feature& feature : features_) {
    if ((p - feature.center).norm() - feature.radius > std::abs(best.distance)) continue;
    const Meridian meridian(feature.axis, p);
    const ShapePoint q = lift(meridian, feature.profile.closest(meridian.at));
    if (std::abs(q.distance) < std::abs(best.distance)) best = q;
  }
  return best;
}

/// The swept features, and between their rims the sphere: a Delaunay triangulation of evenly spread points, made in the
/// plane of the stereographic projection from the centre of the first cap, which turns circles into circles.
Mesh TurnedBall::mesh(double tolerance) const {
  if (features_.empty()) return make_sphere(radius_).mesh(tolerance);
  Mesh mesh;
  std::vector<Ring> rims;
  for (const Feature& feature : features_) {
    const std::vector<Ring> rings =
        sweep(mesh, feature.profile.sample(tolerance / 2), feature.axis, around(feature.profile, tolerance / 2));
    rims.push_back(rings.front());
    if (!on_axis(feature.profile.end())) rims.push_back(rings.back());
  }
  std::vector<Index> on_sphere;
  for (Ring& rim : rims)
    for (Index& v : rim) {
      on_sphere.push_back(v);
      v = static_cast<Index>(on_sphere.size() - 1);
    }
  // A triangle of circumradius c is c²/2r below the sphere.
  const double spacing = std::sqrt(2 * radius_ * tolerance);
  const auto count = static_cast<std::size_t>(4 * std::numbers::pi * radius_ * radius_ / (spacing * spacing));
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double ring = std::sqrt(1 - z * z), angle = golden_angle * static_cast<double>(i);
    const Vec3 direction(ring * std::cos(angle), ring * std::sin(angle), z);
    const bool clear_of_caps = std::all_of(caps_.begin(), caps_.end(), [&](const Cap& cap) {
      const double away = std::acos(std::clamp(direction.dot(cap.axis), -1.0, 1.0)) - std::acos(cap.cosine);
      return away * radius_ > spacing / 2;
    });
    if (!clear_of_caps) continue;
    on_sphere.push_back(static_cast<Index>(mesh.positions.size()));
    mesh.positions.push_back(radius_ * direction);
  }
  const Vec3 pole = caps_.front().axis, first = pole.unitOrthogonal(), second = pole.cross(first);
  std::vector<Vec2> projected;
  for (const Index v : on_sphere) {
    const Vec3& p = mesh.positions[v];
    projected.push_back(Vec2(p.dot(first), p.dot(second)) / (radius_ - p.dot(pole)));
  }
  // Seen from outside the projection from the pole is mirrored.
  for (const auto& [a, b, c] : triangulate_region(projected, rims))
    mesh.faces.add(on_sphere[a], on_sphere[c], on_sphere[b]);
  return mesh;
}

}  // namespace gpsrecon::internal
