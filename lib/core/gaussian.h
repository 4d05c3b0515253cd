#pragma once

#include <gpsrecon/core/mixture.h>

namespace gpsrecon::internal {

/// A Gaussian with what its evaluation needs, factored once.
struct FactoredGaussian {
  Vec3 mean;
  Sym3 covariance;
  Sym3 precision;          ///< Σ⁻¹
  double log_determinant;  ///< ln |Σ|

  /// Precondition: positive definite covariance.
  explicit FactoredGaussian(const Gaussian& g);
};

/// ln f(x), Preiner et al. 2019, Eq. 2.
double log_density(const FactoredGaussian& g, const Vec3& x);

/// (x - μ)ᵀ Σ⁻¹ (x - μ)
inline double squared_mahalanobis(const FactoredGaussian& g, const Vec3& x) {
  return g.precision.quadratic_form(x - g.mean);
}

/// E[(x - μ)ᵀ Σ⁻¹ (x - μ)] of the Gaussian with mean μ and this precision Σ⁻¹ over x of another, whose mean lies
/// `shift` away and which has this covariance: shiftᵀ Σ⁻¹ shift + tr(Σ⁻¹ covariance).
inline double expected_squared_mahalanobis(const Sym3& precision, const Vec3& shift, const Sym3& covariance) {
  return precision.quadratic_form(shift) + trace_of_product(precision, covariance);
}

/// Kullback-Leibler divergence D(a‖b) >= 0, Preiner et al. 2014, Eq. 11, of the expectation above over x of a and the
/// ln |Σ| of both.
inline double kl_divergence(double expectation, double log_determinant_a, double log_determinant_b) {
  return 0.5 * (expectation - 3 - log_determinant_a + log_determinant_b);
}

/// ln of the Bhattacharyya coefficient, <= 0, Preiner et al. 2019, Eq. 19. Symmetric in its arguments to the last bit
/// and invariant under invertible affine maps.
double log_bhattacharyya(const FactoredGaussian& a, const FactoredGaussian& b);

/// The normalised product of two Gaussians, Preiner et al. 2019, Eq. 3 and 5.
Gaussian product(const FactoredGaussian& a, const FactoredGaussian& b);

}  // namespace gpsrecon::internal
