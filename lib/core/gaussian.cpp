// Preiner et al. 2019, Eq. 2 (density), 3 and 5 (product), 19 (Bhattacharyya coefficient).

#include <gpsrecon/core/gaussian.h>

#include <numbers>

namespace gpsrecon::internal {

FactoredGaussian::FactoredGaussian(const Gaussian& g) : mean(g.mean), covariance(g.covariance) {
  const Cholesky3 factor(covariance);
  precision = factor.inverse();
  log_determinant = factor.log_determinant();
}

double log_density(const FactoredGaussian& g, const Vec3& x) {
  return -0.5 * (3 * std::log(2 * std::numbers::pi) + g.log_determinant + squared_mahalanobis(g, x));
}

double log_bhattacharyya(const FactoredGaussian& a, const FactoredGaussian& b) {
  const Cholesky3 mean_covariance(0.5 * (a.covariance + b.covariance));
  const double squared_distance = mean_covariance.solve_lower(a.mean - b.mean).squaredNorm();
  return -0.125 * squared_distance - 0.5 * mean_covariance.log_determinant() +
         0.25 * (a.log_determinant + b.log_determinant);
}

Gaussian product(const FactoredGaussian& a, const FactoredGaussian& b) {
  const Sym3 covariance = Cholesky3(a.precision + b.precision).inverse();
  return {covariance * (a.precision * a.mean + b.precision * b.mean), covariance};
}

}  // namespace gpsrecon::internal
