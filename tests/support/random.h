#pragma once

#include <gpsrecon/core/random.h>
#include <gpsrecon/core/sym3.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace gpsrecon::test {

/// A reproducible sequence of random numbers, vectors and matrices.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : seed_(seed), stream_(stream) {}
  /// Uniform in [low, high).
  double uniform(double low = 0, double high = 1) {
    return low + (high - low) * internal::random_uniform(seed_, stream_, counter_++);
  }
  /// Uniform in 0 .. n - 1.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }
  /// Standard normal (Box and Muller 1958).
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }
  Vec3 normal3() {
    const double x = normal(), y = normal(), z = normal();
    return {x, y, z};
  }
  /// In the cube [low, high)³.
  Vec3 vector(double low = -1, double high = 1) {
    const double x = uniform(low, high), y = uniform(low, high), z = uniform(low, high);
    return {x, y, z};
  }
  std::vector<Vec3> vectors(std::size_t n, double low = -1, double high = 1) {
    std::vector<Vec3> found;
    for (std::size_t i = 0; i < n; ++i) found.push_back(vector(low, high));
    return found;
  }
  Vec3 direction() { return normal3().normalized(); }
  /// Entries in [-1, 1).
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
  /// Eigenvalues log-uniform in [low, high), random axes.
  Sym3 covariance(double low, double high) {
    Vec3 values;
    for (double& value : values) value = low * std::pow(high / low, uniform());
    const Mat3 r = rotation();
    return Sym3::from_matrix(r * values.asDiagonal() * r.transpose());
  }
  template <class T>
  void shuffle(std::vector<T>& values) {
    for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[below(i)]);
  }

 private:
  std::uint64_t seed_, stream_, counter_ = 0;
};

}  // namespace gpsrecon::test
