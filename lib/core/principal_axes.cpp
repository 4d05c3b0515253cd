// Principal component analysis of a neighbourhood: Hoppe et al. 1992.

#include <gpsrecon/core/principal_axes.h>

#include <algorithm>
#include <cmath>

namespace gpsrecon::internal {
namespace {

/// Of the extent across to that along.
constexpr double collinear_ratio = 1e-9;

Vec3 mean_of(std::span<const Vec3> points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  return mean;
}

}  // namespace

Sym3 local_covariance(std::span<const Vec3> points, const Vec3& center, std::span<const Neighbor> near) {
  Vec3 mean = Vec3::Zero();
  for (const Neighbor& n : near) mean += points[n.index] - center;
  mean /= static_cast<double>(near.size());
  Sym3 sum;
  for (const Neighbor& n : near) sum += Sym3::outer(points[n.index] - center - mean);
  return sum * (1.0 / static_cast<double>(near.size()));
}

Sym3 scatter(std::span<const Vec3> points) {
  const Vec3 mean = mean_of(points);
  Sym3 sum;
  for (const Vec3& p : points) sum += Sym3::outer(p - mean);
  return sum;
}

bool on_a_line(std::span<const Vec3> points) {
  const Vec3 mean = mean_of(points), axis = eigen_decomposition(scatter(points)).vectors.col(2);
  // Lengths, not the eigenvalues: squared deviations would lose half the digits of the ratio.
  double along = 0, across = 0;
  for (const Vec3& p : points) {
    const Vec3 d = p - mean;
    along = std::max(along, std::abs(axis.dot(d)));
    across = std::max(across, (d - axis.dot(d) * axis).norm());
  }
  return across <= collinear_ratio * along;
}

}  // namespace gpsrecon::internal
