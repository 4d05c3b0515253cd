#pragma once

#include <gpsrecon/core/random.h>
#include <gpsrecon/core/sym3.h>

#include <Eigen/Geometry>
#include <cmath>

namespace gpsrecon::test {

using namespace internal;

/// A reproducible sequence of random numbers and matrices.
class RandomSequence {
 public:
  explicit RandomSequence(std::uint64_t seed) : seed_(seed) {}
  double uniform(double low = 0, double high = 1) { return low + (high - low) * random_uniform(seed_, 0, counter_++); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }
  /// In the cube [-1, 1]³.
  Vec3 vector() {
    const double x = uniform(-1, 1), y = uniform(-1, 1);
    return {x, y, uniform(-1, 1)};
  }
  Mat3 matrix() {
    Mat3 m;
    for (int k = 0; k < 3; ++k) m.col(k) = vector();
    return m;
  }
  Mat3 rotation() {
    const Vec3 x = vector().normalized();
    const Vec3 y = x.cross(vector()).normalized();
    Mat3 r;
    r << x, y, x.cross(y);
    return r;
  }
  /// Eigenvalues log-uniform in [low, high], random axes.
  Sym3 covariance(double low, double high) {
    Vec3 values;
    for (double& value : values) value = low * std::pow(high / low, uniform());
    const Mat3 r = rotation();
    return Sym3::from_matrix(r * values.asDiagonal() * r.transpose());
  }

 private:
  std::uint64_t seed_, counter_ = 0;
};

}  // namespace gpsrecon::test
