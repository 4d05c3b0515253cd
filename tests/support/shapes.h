#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/point_cloud.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <numeric>
#include <vector>

#include "support/random.h"

/// Sampled analytic surfaces whose distance to any point is known exactly, and the Gaussians that lie in them.
namespace gpsrecon::test {

/// A cloud of these points, without anything else.
inline PointCloud cloud_of(std::vector<Vec3> positions) {
  PointCloud cloud;
  cloud.positions = std::move(positions);
  return cloud;
}

/// Points on a surface, with its outward unit normals there, its area and the distance of any point to it.
struct SampledShape {
  std::vector<Vec3> points;
  std::vector<Vec3> normals;
  double area = 0;
  std::function<double(const Vec3&)> distance;

  /// Side of the area per point.
  double spacing() const { return std::sqrt(area / static_cast<double>(points.size())); }
  PointCloud cloud() const { return cloud_of(points); }
};

/// The stream of random numbers that shapes are made with, apart from those that a test draws by the same seed.
inline constexpr std::uint64_t sampling = 0x7E57;

inline constexpr double golden_angle = 2 * std::numbers::pi * (1 - 0.61803398874989485);

/// n points on a sphere, evenly spread along a spherical Fibonacci spiral.
inline SampledShape fibonacci_sphere(std::size_t n, double radius = 1, const Vec3& center = Vec3::Zero()) {
  SampledShape s;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(n);
    const double ring = std::sqrt(1 - z * z), angle = golden_angle * static_cast<double>(i);
    s.normals.emplace_back(ring * std::cos(angle), ring * std::sin(angle), z);
    s.points.push_back(center + radius * s.normals.back());
  }
  s.area = 4 * std::numbers::pi * radius * radius;
  s.distance = [=](const Vec3& x) { return std::abs((x - center).norm() - radius); };
  return s;
}

/// n independent, uniformly distributed points on a sphere.
inline SampledShape random_sphere(std::size_t n, std::uint64_t seed, double radius = 1,
                                  const Vec3& center = Vec3::Zero()) {
  Random random(seed, sampling);
  SampledShape s = fibonacci_sphere(0, radius, center);
  for (std::size_t i = 0; i < n; ++i) {
    s.normals.push_back(random.direction());
    s.points.push_back(center + radius * s.normals.back());
  }
  return s;
}

/// n points evenly spread on a torus around the z axis. Fibonacci numbers n close the spiral without a seam.
inline SampledShape torus(std::size_t n, double major, double minor) {
  SampledShape s;
  for (std::size_t i = 0; i < n; ++i) {
    const double around = golden_angle * static_cast<double>(i);
    // The share of the area below the tube angle t is (t + minor/major sin t) / 2π.
    const double share = 2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    double t = share;
    for (int step = 0; step < 50; ++step)
      t -= (t + minor / major * std::sin(t) - share) / (1 + minor / major * std::cos(t));
    const Vec3 out(std::cos(around), std::sin(around), 0);
    s.normals.push_back(std::cos(t) * out + std::sin(t) * Vec3::UnitZ());
    s.points.push_back(major * out + minor * s.normals.back());
  }
  s.area = 4 * std::numbers::pi * std::numbers::pi * major * minor;
  s.distance = [=](const Vec3& x) { return std::abs(std::hypot(std::hypot(x.x(), x.y()) - major, x.z()) - minor); };
  return s;
}

/// n independent, uniformly distributed points on the rectangle |x| <= a/2, |y| <= b/2 of the plane z = height.
inline SampledShape rectangle(std::size_t n, double a, double b, std::uint64_t seed, double height = 0) {
  Random random(seed, sampling);
  SampledShape s;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = random.uniform(-a / 2, a / 2), y = random.uniform(-b / 2, b / 2);
    s.points.emplace_back(x, y, height);
  }
  s.normals.assign(n, Vec3::UnitZ());
  s.area = a * b;
  s.distance = [=](const Vec3& x) {
    const Vec3 outside(std::max(0.0, std::abs(x.x()) - a / 2), std::max(0.0, std::abs(x.y()) - b / 2), x.z() - height);
    return outside.norm();
  };
  return s;
}

/// n independent, uniformly distributed points on the surface of the box |x| <= half.
inline SampledShape box(std::size_t n, const Vec3& half, std::uint64_t seed) {
  Random random(seed, sampling);
  SampledShape s;
  const Vec3 side_area(4 * half.y() * half.z(), 4 * half.x() * half.z(), 4 * half.x() * half.y());
  s.area = 2 * side_area.sum();
  for (std::size_t i = 0; i < n; ++i) {
    const double pick = random.uniform(0, side_area.sum());
    const int axis = pick < side_area.x() ? 0 : pick < side_area.x() + side_area.y() ? 1 : 2;
    const double side = random.uniform() < 0.5 ? -1 : 1;
    Vec3 p = random.vector().cwiseProduct(half);
    p[axis] = side * half[axis];
    s.points.push_back(p);
    s.normals.push_back(side * Vec3::Unit(axis));
  }
  s.distance = [=](const Vec3& x) {
    const Vec3 beyond = x.cwiseAbs() - half;
    return beyond.maxCoeff() > 0 ? beyond.cwiseMax(0).norm() : -beyond.maxCoeff();
  };
  return s;
}

/// Those points of the shape that `keep` tells.
template <class Keep>
SampledShape part(const SampledShape& shape, const Keep& keep) {
  SampledShape p = shape;
  p.points.clear();
  p.normals.clear();
  for (std::size_t i = 0; i < shape.points.size(); ++i)
    if (keep(shape.points[i])) {
      p.points.push_back(shape.points[i]);
      p.normals.push_back(shape.normals[i]);
    }
  p.area *= static_cast<double>(p.points.size()) / static_cast<double>(shape.points.size());
  return p;
}

/// The points of both, those of `b` last.
inline SampledShape joined(SampledShape a, const SampledShape& b) {
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
  a.area += b.area;
  a.distance = [first = a.distance, second = b.distance](const Vec3& x) { return std::min(first(x), second(x)); };
  return a;
}

/// Two parallel squares of side `side`, `gap` apart, n points each: the lower sheet first. Normals point apart.
inline SampledShape two_sheets(std::size_t n, double side, double gap, std::uint64_t seed) {
  SampledShape lower = rectangle(n, side, side, seed, -gap / 2);
  for (Vec3& normal : lower.normals) normal = -normal;
  return joined(lower, rectangle(n, side, side, seed + 1, gap / 2));
}

/// Moves every point along its normal by Gaussian noise.
inline void add_noise(SampledShape& shape, double sigma, std::uint64_t seed) {
  Random random(seed, sampling);
  for (std::size_t i = 0; i < shape.points.size(); ++i) shape.points[i] += sigma * random.normal() * shape.normals[i];
}

/// Independent points on the unit sphere with Gaussian noise along the radius.
inline PointCloud noisy_sphere(std::size_t n, double noise, std::uint64_t seed = 1) {
  SampledShape sphere = random_sphere(n, seed);
  add_noise(sphere, noise, seed + 1);
  return sphere.cloud();
}

/// Coordinates rounded to multiples of 2^-20, so that whole numbers can be added without rounding.
inline PointCloud on_grid(PointCloud cloud) {
  for (Vec3& p : cloud.positions)
    for (double& x : p) x = std::ldexp(std::nearbyint(std::ldexp(x, 20)), -20);
  return cloud;
}

inline PointCloud scaled(PointCloud cloud, double factor) {
  for (Vec3& p : cloud.positions) p *= factor;
  return cloud;
}

inline PointCloud shifted(PointCloud cloud, const Vec3& shift) {
  for (Vec3& p : cloud.positions) p += shift;
  return cloud;
}

/// A flat Gaussian with deviation `across` along the unit normal and `along` in the plane.
inline Sym3 disc_covariance(const Vec3& normal, double along, double across) {
  return Sym3::identity(along * along) + (across * across - along * along) * Sym3::outer(normal);
}

/// One flat Gaussian of unit weight per point, in the tangent plane: deviations `along` and `across` in spacings.
inline Mixture tangent_discs(const SampledShape& shape, double along = 0.6, double across = 0.1) {
  Mixture m;
  m.means = shape.points;
  m.weights.assign(shape.points.size(), 1.0);
  m.spacing = shape.spacing();
  for (const Vec3& normal : shape.normals)
    m.covariances.push_back(disc_covariance(normal, along * m.spacing, across * m.spacing));
  return m;
}

/// The components of both, those of `b` last.
inline Mixture joined(Mixture a, const Mixture& b) {
  a.means.insert(a.means.end(), b.means.begin(), b.means.end());
  a.covariances.insert(a.covariances.end(), b.covariances.begin(), b.covariances.end());
  a.weights.insert(a.weights.end(), b.weights.begin(), b.weights.end());
  return a;
}

/// Weight, mean and covariance of a mixture as one distribution.
struct Moments {
  double weight = 0;
  Vec3 mean = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
};
inline Moments moments(const Mixture& m) {
  Moments all;
  all.weight = std::accumulate(m.weights.begin(), m.weights.end(), 0.0);
  for (std::size_t s = 0; s < m.size(); ++s) all.mean += m.weights[s] / all.weight * m.means[s];
  for (std::size_t s = 0; s < m.size(); ++s) {
    const Vec3 d = m.means[s] - all.mean;
    all.covariance += m.weights[s] / all.weight * (m.covariances[s].matrix() + d * d.transpose());
  }
  return all;
}

}  // namespace gpsrecon::test
