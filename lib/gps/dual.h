#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/sym3.h>

namespace gpsrecon::internal {

/// The image q = (vech Σ⁻¹, Σ⁻¹μ) of a Gaussian in R⁹ (Preiner et al. 2019, Eq. 11). Products of powers of Gaussians
/// are linear combinations here (Eq. 9), and so are the tangents of a subdivision surface.
using DualPoint = Eigen::Matrix<double, 9, 1>;

/// [q̂]: the quadratic part as a matrix.
inline Sym3 quadratic_part(const DualPoint& q) {
  return {q[0], q[1], q[2], q[3], q[4], q[5]};
}

/// q̄: the linear part.
inline Vec3 linear_part(const DualPoint& q) {
  return q.tail<3>();
}

/// F. Precondition: positive definite covariance. The mean should be near the origin: digits of q̄ are lost in
/// proportion to its distance.
inline DualPoint to_dual(const Gaussian& g) {
  const Sym3 precision = Cholesky3(g.covariance).inverse();
  DualPoint q;
  q << precision.xx, precision.xy, precision.xz, precision.yy, precision.yz, precision.zz, precision * g.mean;
  return q;
}

/// F⁻¹ at one dual point (Eq. 12), factored once so that tangents and variances there are cheap.
class DualMap {
 public:
  /// Precondition: [q̂] is positive definite, as it is for every convex combination of images of Gaussians.
  explicit DualMap(const DualPoint& q) : factor_(quadratic_part(q)), mean_(factor_.solve(linear_part(q))) {}

  const Vec3& mean() const { return mean_; }
  Sym3 covariance() const { return factor_.inverse(); }
  /// Σ n
  Vec3 covariance_times(const Vec3& n) const { return factor_.solve(n); }
  /// Σ⁻¹ μ_u = q̄_u - [q̂_u] μ, where μ_u is the tangent in space that belongs to a tangent q_u in R⁹ (appendix B).
  Vec3 cotangent(const DualPoint& q_u) const { return linear_part(q_u) - quadratic_part(q_u) * mean_; }
  /// μ_u
  Vec3 tangent(const DualPoint& q_u) const { return factor_.solve(cotangent(q_u)); }

 private:
  Cholesky3 factor_;
  Vec3 mean_;
};

/// F⁻¹. Precondition as of DualMap.
inline Gaussian from_dual(const DualPoint& q) {
  const DualMap map(q);
  return {map.mean(), map.covariance()};
}

}  // namespace gpsrecon::internal
