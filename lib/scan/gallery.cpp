#include "gallery.h"

#include <gpsrecon/core/error.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "gyroid.h"

namespace gpsrecon::internal {
namespace {

constexpr double gyroid_radius = 4.5;
constexpr int gyroid_euler = -2;

/// A disc of thickness 0.6 whose top is a train of circular waves of length 1, tangent to each other, around a crest on
/// the axis. The waves meet the side at a sharp edge.
Lathe make_ripple() {
  constexpr int half_waves = 5;
  constexpr double rim = 0.25 + 0.5 * half_waves;
  Profile outline({0, -0.6});
  outline.line_to({rim, -0.6}).line_to({rim, 0});
  // Quarter circles: their chords are half a wave long, their centres a quarter of it above or below the middle.
  double rho = rim;
  for (int k = 0; k < half_waves; ++k, rho -= 0.5) {
    const Vec2 end(rho - 0.5, 0);
    if (k % 2 == 0)
      outline.arc_right_to(end, {rho - 0.25, 0.25});
    else
      outline.arc_left_to(end, {rho - 0.25, -0.25});
  }
  const double radius = 0.25 * std::numbers::sqrt2;
  outline.arc_left_to({0, radius - 0.25}, {0, -0.25});
  return Lathe(outline);
}

/// A block with a stepped, L-shaped outline and a hole through it: sharp edges at right and obtuse angles, convex and
/// concave, and two soft ones.
Prism make_block() {
  Profile outline({-2, -1.5});
  outline.line_to({2, -1.5}).line_to({2, -0.3}).arc_left_to({1.6, 0.1}, {1.6, -0.3});
  outline.line_to({0.6, 0.1}).arc_right_to({0.2, 0.5}, {0.6, 0.5}).line_to({0.2, 1.1});
  outline.line_to({-0.2, 1.5}).line_to({-1, 1.5}).line_to({-1, 1}).line_to({-2, 1}).line_to({-2, -1.5});
  Profile hole({-0.4, -0.4});
  hole.arc_right_to({-1.4, -0.4}, {-0.9, -0.4}).arc_right_to({-0.4, -0.4}, {-0.9, -0.4});
  return {{outline, hole}, 1};
}

/// Four parallel sheets on a base, 0.16, 0.08, 0.04 and 0.02 thick, 0.4, 0.3 and 0.2 apart.
Prism make_fins() {
  constexpr double top = 0.7, base = -0.4, bottom = -0.7, margin = 0.2;
  const std::pair<double, double> fins[] = {{0.62, 0.64}, {0.38, 0.42}, {0, 0.08}, {-0.56, -0.4}};  // right to left
  Profile outline({fins[3].first - margin, bottom});
  outline.line_to({fins[0].second + margin, bottom}).line_to({fins[0].second + margin, base});
  for (const auto& [left, right] : fins)
    outline.line_to({right, base}).line_to({right, top}).line_to({left, top}).line_to({left, base});
  outline.line_to({fins[3].first - margin, base}).line_to(outline.start());
  return {{outline}, 0.7};
}

/// A round bottle with a narrow neck and an open, flaring mouth.
Lathe make_vase() {
  const Vec2 shoulder(std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2), neck = 1.6 * shoulder;
  const Vec2 mouth = neck + 0.6 * Vec2(-0.5, std::numbers::sqrt3 / 2);
  return Lathe(Profile({0, -1}).arc_left_to(shoulder, {0, 0}).arc_right_to(mouth, neck));
}

// The features of the workpiece.

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

template <class T>
std::unique_ptr<const Shape> owned(T shape) {
  return std::make_unique<T>(std::move(shape));
}

struct Entry {
  GalleryShape shape;
  std::unique_ptr<const Shape> (*make)();
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list = {
      {{"sphere", "a sphere", 2, 0}, [] { return owned(make_sphere(1)); }},
      {{"torus", "a torus", 0, 0}, [] { return owned(make_torus(2, 0.7)); }},
      {{"knot", "a tube around the trefoil knot", 0, 0}, [] { return owned(Knot(0.5)); }},
      {{"ripple", "a disc with circular waves and sharp rims", 2, 0}, [] { return owned(make_ripple()); }},
      {{"rounded-box", "a box with rounded edges", 2, 0},
       [] {
         return owned(RoundedBox({2, 1.5, 1}, 0.3));
       }},
      {{"block", "a machined block with sharp and soft edges and a hole", 0, 0}, [] { return owned(make_block()); }},
      {{"fins", "thin sheets on a base, close to each other", 2, 0}, [] { return owned(make_fins()); }},
      {{"gyroid", "a labyrinth of the gyroid in a ball, edges rounded", gyroid_euler, 0},
       [] { return owned(Gyroid(gyroid_radius, 0.8)); }},
      {{"vase", "an open surface with one boundary loop", 1, 1}, [] { return owned(make_vase()); }},
      {{"workpiece", "a ball with turned features, sharp and soft", 0, 0}, [] { return owned(make_workpiece()); }}};
  return list;
}

}  // namespace

const std::vector<GalleryShape>& gallery() {
  static const std::vector<GalleryShape> shapes = [] {
    std::vector<GalleryShape> list;
    for (const Entry& entry : entries()) list.push_back(entry.shape);
    return list;
  }();
  return shapes;
}

std::unique_ptr<const Shape> make_shape(const std::string& name) {
  std::string names;
  for (const Entry& entry : entries()) {
    if (entry.shape.name == name) return entry.make();
    names += (names.empty() ? "" : ", ") + entry.shape.name;
  }
  throw OptionError("there is no shape '" + name + "', only " + names);
}

TurnedBall make_workpiece() {
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

}  // namespace gpsrecon::internal
