// Preiner et al. 2014, section 5.3, Eq. 12 (squared here, as it scales a covariance) and 25-26 (balanced weights).

#include <gpsrecon/hem/initial_mixture.h>

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/principal_axes.h>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace gpsrecon::internal {
namespace {

/// Largest spacing a point is given, in spacings of the cloud.
constexpr double max_sparseness = 3;
/// Share of a sparse point's additional squared spacing that widens its kernel too, as in Scale::sigma0_local.
constexpr double kernel_share = 0.4 * 0.4;

/// Squared spacing around a point: that of the cloud, but more where the points are clearly sparser, or the Gaussians
/// there would not overlap. k points spread evenly over a disc at spacing A have λmax = k A²/(4π); the factor 0.6 keeps
/// the scatter of that estimate from widening Gaussians of an even cloud.
double squared_local_spacing(double largest_eigenvalue, std::size_t k, double spacing) {
  const double estimate = 0.6 * 4 * std::numbers::pi * largest_eigenvalue / static_cast<double>(k);
  return std::clamp(estimate, spacing * spacing, max_sparseness * max_sparseness * spacing * spacing);
}

/// Weights w_i = 1/v_i, v_i = Σ_j w_j θ(|p_i - p_j|), θ(r) = exp(-r²/(h/4)²) (Preiner et al. 2014, Eq. 25-26),
/// renormalised to the number of points. The support h is six spacings: h/4 then holds a handful of points.
void balance_weights(const PointCloud& cloud, const Neighbors& index, double spacing, std::vector<double>& weights,
                     const RunContext& context) {
  const double quarter = 6 * spacing / 4;
  const double total = parallel_sum<double>(weights.size(), context, [&](std::size_t i) { return weights[i]; });
  std::vector<double> balanced(weights.size());
  parallel_blocks(weights.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> found;
    for (std::size_t i = begin; i < end; ++i) {
      index.within(cloud.positions[i], 3 * quarter, found);
      double density = 0;
      for (const Neighbor& n : found) {
        const double r = n.distance / quarter;
        density += weights[n.index] * std::exp(-r * r);
      }
      balanced[i] = weights[i] / density;
    }
  });
  const double sum = parallel_sum<double>(balanced.size(), context, [&](std::size_t i) { return balanced[i]; });
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = balanced[i] * (total / sum);
}

}  // namespace

Mixture initial_mixture(const PointCloud& cloud, const Neighbors& index, const Kernel& kernel,
                        const HemOptions& options, const RunContext& context) {
  const std::size_t n = cloud.size();
  const double variance = kernel.sigma0 * kernel.sigma0;
  Mixture mixture;
  mixture.frame = cloud.frame;
  mixture.sigma0 = kernel.sigma0;
  mixture.spacing = kernel.spacing;
  mixture.means = cloud.positions;
  mixture.covariances.assign(n, Sym3::identity(variance));
  mixture.kernels = kernel.sigma0_at;
  for (std::size_t i = 0; i < mixture.kernels.size(); ++i)
    mixture.covariances[i] = Sym3::identity(mixture.kernels[i] * mixture.kernels[i]);
  mixture.weights = cloud.weights;
  if (mixture.weights.empty()) mixture.weights.assign(n, 1.0);

  if (!cloud.sensors.empty()) {
    mixture.outward.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 way = cloud.sensors[i] - cloud.positions[i];
      mixture.outward[i] = way.allFinite() ? Vec3(way.stableNormalized()) : Vec3(Vec3::Zero());
    }
  }
  const bool local = options.initial == InitialCovariance::local;
  const auto has_normal = [&cloud](std::size_t i) {
    return !cloud.normals.empty() && std::isfinite(cloud.normals[i].norm()) && cloud.normals[i].norm() > 0;
  };
  bool estimate_normals = false;
  if (options.normals) {
    mixture.normals.assign(n, Vec3::UnitZ());
    mixture.normal_variances.assign(n, 0.0);  // concentration ρ = 1
    for (std::size_t i = 0; i < n; ++i) {
      if (has_normal(i))
        mixture.normals[i] = cloud.normals[i].normalized();
      else
        estimate_normals = true;
    }
  }
  if (!local && !estimate_normals && !options.balance) return mixture;

  if (local || estimate_normals) {
    parallel_blocks(
        n, context,
        [&](std::size_t, std::size_t begin, std::size_t end) {
          std::vector<Neighbor> near;
          for (std::size_t i = begin; i < end; ++i) {
            const double spacing = kernel.spacing_at.empty() ? kernel.spacing : kernel.spacing_at[i];
            index.nearest(cloud.positions[i], static_cast<std::size_t>(options.neighbors), near);
            // Repeated points and those of a scan line do not show the surface: then all in the disc that so many
            // points spread evenly would fill.
            const double disc = spacing * std::sqrt(options.neighbors / std::numbers::pi);
            if (near.back().distance < 0.5 * disc) index.within(cloud.positions[i], disc, near);
            const Sym3 covariance = local_covariance(cloud.positions, cloud.positions[i], near);
            const Eigen3 e = eigen_decomposition(covariance);
            if (estimate_normals && !has_normal(i)) mixture.normals[i] = e.vectors.col(0);
            if (local && e.values[2] > 0) {
              // Scaled so that its largest deviation is the spacing: comparable from point to point, whatever k was.
              const double spacing2 = squared_local_spacing(e.values[2], near.size(), spacing);
              mixture.covariances[i] += spacing2 / e.values[2] * covariance;
              mixture.covariances[i] += Sym3::identity(kernel_share * (spacing2 - spacing * spacing));
            }
          }
        },
        1024);
  }
  if (options.balance) balance_weights(cloud, index, kernel.spacing, mixture.weights, context);
  return mixture;
}

}  // namespace gpsrecon::internal
