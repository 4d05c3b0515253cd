#include "datasets/example.h"

#include <Eigen/Geometry>
#include <cmath>

namespace gpsrecon::datasets {
namespace {

constexpr double ball_radius = 20;

/// The point of the sphere at a distance from the axis, on its upper half.
Vec2 rim(double rho) {
  return {rho, std::sqrt(ball_radius * ball_radius - rho * rho)};
}

/// A cylinder with a flat top, standing on the sphere in a concave crease.
Profile boss(double radius, double height) {
  return Profile(rim(radius)).line_to({radius, height}).line_to({0, height});
}

/// A ball on the axis, joined to the sphere by a fillet that touches both tangentially.
Profile knob(double knob_radius, double knob_height, double fillet_radius) {
  // The centre of the fillet is where the two balls, grown by its radius, meet.
  const double to_ball = ball_radius + fillet_radius, to_knob = knob_radius + fillet_radius;
  const double z = (to_ball * to_ball - to_knob * to_knob + knob_height * knob_height) / (2 * knob_height);
  const Vec2 fillet(std::sqrt(to_ball * to_ball - z * z), z);
  const Vec2 center(0, knob_height);
  const Vec2 foot = fillet * (ball_radius / to_ball);
  const Vec2 neck = center + (fillet - center) * (knob_radius / to_knob);
  return Profile(foot).arc_right_to(neck, fillet).arc_left_to({0, knob_height + knob_radius}, center);
}

Profile bore(double radius) {
  const Vec2 top = rim(radius);
  return Profile(top).line_to({radius, -top.y()});
}

Profile conical_pit(double radius, double bottom) {
  return Profile(rim(radius)).line_to({0, bottom});
}

Profile flat(double radius) {
  return Profile(rim(radius)).line_to({0, rim(radius).y()});
}

}  // namespace

TurnedBall example_solid() {
  // Turned out of the coordinate axes, so that nothing is aligned with them.
  const Mat3 pose = (Eigen::AngleAxisd(0.5, Vec3::UnitX()) * Eigen::AngleAxisd(0.3, Vec3::UnitY())).toRotationMatrix();
  TurnedBall solid(ball_radius);
  solid.add(pose * Vec3::UnitX(), bore(9));
  solid.add(pose * Vec3::UnitZ(), knob(7, 31, 6));
  solid.add(pose * -Vec3::UnitZ(), boss(9, 27));
  solid.add(pose * Vec3::UnitY(), flat(10.5));
  solid.add(pose * -Vec3::UnitY(), conical_pit(7, 12));
  return solid;
}

ScanOptions example_scan() {
  ScanOptions options;
  options.points = 100'000;
  options.views = 36;
  options.distance = 4;
  options.max_incidence = 1.3;
  options.noise = 0.04;
  options.registration_shift = 0.01;
  options.registration_angle = 0.0005;
  options.outliers = 100;
  return options;
}

}  // namespace gpsrecon::datasets
