#pragma once

#include <gpsrecon/clop/project.h>
#include <array>
#include <cmath>

namespace gpsrecon::internal {

// The localised L1 kernel of the projection operators, for a support radius of 1: lengths below are in support radii.

/// θ(r) = exp(-r²/(1/4)²), Preiner et al. 2014, section 3.
inline double theta(double r) {
  return std::exp(-16 * r * r);
}

/// α̂(r) = Σ_k w_k exp(-r²/(2 σ_k²)), a sum of Gaussians in place of α(r) = θ(r)/r (Preiner et al. 2014, Eq. 16).
struct KernelFit {
  std::array<double, 3> weight;     ///< w_k
  std::array<double, 3> deviation;  ///< σ_k, descending

  double operator()(double r) const {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += weight[k] * std::exp(-r * r / (2 * deviation[k] * deviation[k]));
    return sum;
  }
};

constexpr KernelFit kernel_fit(KernelCoefficients coefficients) {
  if (coefficients == KernelCoefficients::tail) return {{5.06884, 11.9322, 61.50926}, {0.157, 0.07289, 0.02102}};
  return {{11.4527327, 29.8858795, 97.7605615}, {0.117719940, 0.032869803, 0.010097481}};
}

}  // namespace gpsrecon::internal
