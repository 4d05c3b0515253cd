#include "clouds.h"

#include <gpsrecon/core/random.h>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace gpsrecon::test {

using namespace internal;
namespace {

constexpr std::uint64_t seed = 20;

double uniform(std::uint64_t stream, std::size_t i) {
  return random_uniform(seed, stream, i);
}

/// Box and Muller.
double normal(std::uint64_t stream, std::size_t i) {
  return std::sqrt(-2 * std::log(1 - uniform(stream, 2 * i))) *
         std::cos(2 * std::numbers::pi * uniform(stream, 2 * i + 1));
}

}  // namespace

std::vector<Vec3> noisy_sphere(std::size_t n, double noise) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(n);
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / std::numbers::phi;
    const double r = std::sqrt(1 - z * z);
    points.emplace_back((1 + noise * normal(1, i)) * Vec3(r * std::cos(angle), r * std::sin(angle), z));
  }
  return points;
}

std::vector<Vec3> noisy_torus(std::size_t n, double noise) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double u = 2 * std::numbers::pi * static_cast<double>(i) / std::numbers::phi;
    const double v = 2 * std::numbers::pi * (static_cast<double>(i) + uniform(2, i)) / static_cast<double>(n);
    const double r = 0.4 + noise * normal(3, i);
    points.emplace_back((1 + r * std::cos(v)) * std::cos(u), (1 + r * std::cos(v)) * std::sin(u), r * std::sin(v));
  }
  return points;
}

std::vector<Vec3> flat_sheet(std::size_t n) {
  std::vector<Vec3> points;
  const double step = 1 / static_cast<double>(n);
  for (std::size_t i = 0; i < n * n; ++i) {
    const std::size_t column = i % n, row = i / n;
    points.emplace_back(step * (static_cast<double>(column) + uniform(4, i) / 3),
                        step * (static_cast<double>(row) + uniform(5, i) / 3), 0.0);
  }
  return points;
}

std::string ply_of(const std::vector<Vec3>& points) {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points.size()) +
                     "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
  for (const Vec3& p : points) text.append(reinterpret_cast<const char*>(p.data()), 3 * sizeof(double));
  return text;
}

std::string xyz_of(const std::vector<Vec3>& points) {
  std::string text;
  char line[100];
  for (const Vec3& p : points) {
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g\n", p.x(), p.y(), p.z());
    text += line;
  }
  return text;
}

}  // namespace gpsrecon::test
