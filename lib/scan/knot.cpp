#include <gpsrecon/core/error.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "shape_meshing.h"
#include "shapes.h"

namespace gpsrecon::internal {
namespace {

constexpr std::size_t sample_count = 512, run = 16, half_run = run / 2;
constexpr double step = 2 * std::numbers::pi / sample_count;

/// The centre line at t, with its first two derivatives.
struct CurvePoint {
  Vec3 position, velocity, acceleration;
};

CurvePoint trefoil(double t) {
  const double c2 = std::cos(2 * t), s2 = std::sin(2 * t), c3 = std::cos(3 * t), s3 = std::sin(3 * t);
  const double r = 2 + c3, r1 = -3 * s3, r2 = -9 * c3;
  return {{r * c2, r * s2, s3},
          {r1 * c2 - 2 * r * s2, r1 * s2 + 2 * r * c2, 3 * c3},
          {r2 * c2 - 4 * r1 * s2 - 4 * r * c2, r2 * s2 + 4 * r1 * c2 - 4 * r * s2, -9 * s3}};
}

/// The parameter in (t - step, t + step) where p is closest, by Newton's method on the derivative of half the squared
/// distance, kept inside a shrinking bracket.
double refine(const Vec3& p, double t) {
  double low = t - step, high = t + step;
  for (int iteration = 0; iteration < 60 && high - low > 1e-16; ++iteration) {
    const CurvePoint c = trefoil(t);
    const double slope = (c.position - p).dot(c.velocity);
    const double bend = c.velocity.squaredNorm() + (c.position - p).dot(c.acceleration);
    (slope > 0 ? high : low) = t;
    const double newton = t - slope / bend;
    const double next = bend > 0 && newton > low && newton < high ? newton : (low + high) / 2;
    if (std::abs(next - t) <= 1e-16 * (1 + std::abs(t))) return next;
    t = next;
  }
  return t;
}

/// Coordinate k of the curve where it is largest (sign 1) or least (sign -1) in [t - step, t + step], by ternary
/// search.
double extreme(int k, double sign, double t) {
  double low = t - step, high = t + step;
  const auto at = [&](double s) { return sign * trefoil(s).position[k]; };
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double left = (2 * low + high) / 3, right = (low + 2 * high) / 3;
    (at(left) < at(right) ? low : high) = at(left) < at(right) ? left : right;
  }
  return sign * at(low);
}

Vec3 perpendicular(const Vec3& v, const Vec3& tangent) {
  return v - v.dot(tangent) * tangent;
}

/// The tube at angle `phi` around the centre line, counted from the direction away from the curve's own torus.
Vec3 tube(double t, double phi, double radius) {
  const CurvePoint c = trefoil(t);
  const Vec3 tangent = c.velocity.normalized();
  const Vec3 away(std::cos(3 * t) * std::cos(2 * t), std::cos(3 * t) * std::sin(2 * t), std::sin(3 * t));
  const Vec3 first = perpendicular(away, tangent).normalized();
  return c.position + radius * (std::cos(phi) * first + std::sin(phi) * tangent.cross(first));
}

}  // namespace

Knot::Knot(double radius) : radius_(radius), longest_step_(0) {
  if (!(radius > 0 && radius <= 0.6)) throw OptionError("the radius of a knot is out of range (0, 0.6]");
  Vec3 low = Vec3::Zero(), high = low;
  for (std::size_t i = 0; i < sample_count; ++i) {
    const CurvePoint c = trefoil(static_cast<double>(i) * step);
    samples_.push_back(c.position);
    // The speed is between 3.6 and 6.7 and changes little within a step.
    longest_step_ = std::max(longest_step_, 1.01 * step * c.velocity.norm());
  }
  for (int k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < sample_count; ++i) {
      low[k] = std::min(low[k], extreme(k, -1, static_cast<double>(i) * step));
      high[k] = std::max(high[k], extreme(k, 1, static_cast<double>(i) * step));
    }
  diagonal_ = (high - low + Vec3::Constant(2 * radius)).norm();
}

/// The squared distance of the sample nearest to p. Of a run of samples only those whose middle is near enough are
/// visited.
double Knot::nearest_sample(const Vec3& p) const {
  std::array<double, sample_count / run> middle;
  std::size_t first = 0;
  for (std::size_t r = 0; r < middle.size(); ++r) {
    middle[r] = (samples_[r * run + half_run] - p).norm();
    if (middle[r] < middle[first]) first = r;
  }
  double nearest = middle[first] * middle[first];
  for (std::size_t r = 0; r < middle.size(); ++r) {
    if (const double least = middle[r] - longest_step_ * half_run; least > 0 && least * least > nearest) continue;
    for (std::size_t i = r * run; i < (r + 1) * run; ++i) nearest = std::min(nearest, (samples_[i] - p).squaredNorm());
  }
  return nearest;
}

double Knot::clearance(const Vec3& p) const {
  const double bound = std::sqrt(nearest_sample(p)) - longest_step_ / 2 - radius_;
  return bound > longest_step_ ? bound : std::abs(closest(p).distance);
}

ShapePoint Knot::closest(const Vec3& p) const {
  // The closest point is within half a step of a sample; of those that are in question only local minima are refined.
  const double bound = std::sqrt(nearest_sample(p)) + longest_step_ / 2;
  const auto squared = [&](std::size_t i) { return (samples_[i % sample_count] - p).squaredNorm(); };
  CurvePoint best;
  double best_squared = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < sample_count; r += run) {
    if (std::sqrt(squared(r + half_run)) - longest_step_ * half_run > bound) continue;
    for (std::size_t i = r; i < r + run; ++i) {
      const double here = squared(i);
      if (here > bound * bound || squared(i + sample_count - 1) < here || squared(i + 1) < here) continue;
      const CurvePoint c = trefoil(refine(p, static_cast<double>(i) * step));
      const double candidate = (c.position - p).squaredNorm();
      if (candidate < best_squared) best = c, best_squared = candidate;
    }
  }
  const double away = std::sqrt(best_squared);
  const Vec3 normal = away > 1e-14 ? Vec3((p - best.position) / away) : best.velocity.unitOrthogonal();
  return {best.position + radius_ * normal, normal, away - radius_};
}

/// A grid over the parameters, as fine as the second derivatives demand: linear interpolation over a triangle with legs
/// a and b is off by at most (a²|X_aa| + 2ab|X_ab| + b²|X_bb|) / 8.
Mesh Knot::mesh(double tolerance) const {
  double bend = 0;
  constexpr double h = 1e-3;
  for (std::size_t i = 0; i < sample_count; ++i)
    for (int quarter = 0; quarter < 8; ++quarter) {
      const double t = static_cast<double>(i) * step, phi = quarter * std::numbers::pi / 4;
      bend = std::max(bend, (tube(t - h, phi, radius_) - 2 * tube(t, phi, radius_) + tube(t + h, phi, radius_)).norm());
    }
  bend /= h * h;
  const auto steps = [&](double second_derivative) {
    return static_cast<std::size_t>(std::ceil(2 * std::numbers::pi / std::sqrt(2 * tolerance / second_derivative)));
  };
  const std::size_t along = steps(bend), across = std::max<std::size_t>(3, steps(radius_));
  Mesh mesh;
  for (std::size_t i = 0; i < along; ++i)
    for (std::size_t j = 0; j < across; ++j)
      mesh.positions.push_back(tube(2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(along),
                                    2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(across),
                                    radius_));
  const auto at = [&](std::size_t i, std::size_t j) { return static_cast<Index>(i % along * across + j % across); };
  for (std::size_t i = 0; i < along; ++i)
    for (std::size_t j = 0; j < across; ++j) add_quad(mesh, at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
  return mesh;
}

}  // namespace gpsrecon::internal
