#pragma once

#include <gpsrecon/core/vec.h>
#include <cmath>

namespace gpsrecon {

/// Where data lives: world = origin + 2^exponent * local. Stages work on local coordinates, centred and scaled so that
/// the robust box of the cloud has a diagonal in [1, 2); scaling by a power of two is exact in both directions.
struct Frame {
  Vec3 origin = Vec3::Zero();
  int exponent = 0;

  double scale() const { return std::ldexp(1.0, exponent); }
  Vec3 to_world(const Vec3& local) const { return origin + scale() * local; }
  Vec3 to_local(const Vec3& world) const { return (world - origin) * std::ldexp(1.0, -exponent); }
  bool is_identity() const { return exponent == 0 && origin.isZero(0); }
  friend bool operator==(const Frame& a, const Frame& b) { return a.origin == b.origin && a.exponent == b.exponent; }
};

}  // namespace gpsrecon
