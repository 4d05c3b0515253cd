#pragma once

#include "support/shapes.h"

namespace gpsrecon::test {

using namespace internal;

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

}  // namespace gpsrecon::test
