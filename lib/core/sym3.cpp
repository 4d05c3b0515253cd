// Largest eigenvalue in closed form: Smith 1961, "Eigenvalues of a symmetric 3 × 3 matrix".

#include <gpsrecon/core/sym3.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace gpsrecon {

Eigen3 eigen_decomposition(const Sym3& a) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(a.matrix());
  return {solver.eigenvalues(), solver.eigenvectors()};
}

double largest_eigenvalue(const Sym3& a) {
  // Trigonometric solution of the characteristic cubic.
  const double mean = a.trace() / 3;
  const Sym3 b = a - Sym3::identity(mean);
  const double p2 = trace_of_product(b, b) / 6;
  if (!(p2 > 0)) return mean;
  const double p = std::sqrt(p2);
  const double half_det = std::clamp((b * (1 / p)).determinant() / 2, -1.0, 1.0);
  return mean + 2 * p * std::cos(std::acos(half_det) / 3);
}

Sym3 floor_eigenvalues(const Sym3& a, double relative_floor) {
  // λmin = |A| / (λmid λmax) >= |A| / tr², a bound that spares the decomposition of all but the flattest.
  const double trace = a.trace();
  if (a.determinant() >= relative_floor * trace * trace * trace * (1 + 1e-9)) return a;
  const Eigen3 e = eigen_decomposition(a);
  const double floor = relative_floor * e.values[2];
  if (e.values[0] >= floor) return a;
  Sym3 floored;
  for (int k = 0; k < 3; ++k) floored += std::max(e.values[k], floor) * Sym3::outer(e.vectors.col(k));
  return floored;
}

}  // namespace gpsrecon
