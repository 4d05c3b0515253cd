// Log-likelihood of points under a mixture: the density of Preiner et al. 2014, Eq. 7.

#include <gpsrecon/hem/likelihood.h>

#include <gpsrecon/core/component_search.h>
#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace gpsrecon::internal {
namespace {

/// ln Σ exp(terms), the largest factored out.
double log_sum_exp(const std::vector<double>& terms) {
  const double largest = *std::max_element(terms.begin(), terms.end());
  double sum = 0;
  for (const double t : terms) sum += std::exp(t - largest);
  return largest + std::log(sum);
}

}  // namespace

std::vector<double> log_likelihoods(const Mixture& mixture, std::span<const Vec3> points,
                                    const LikelihoodOptions& options, const RunContext& context) {
  options.check();
  if (mixture.empty()) throw InvariantError("no likelihood under an empty mixture");
  const ComponentSearch search(mixture);
  const double total = std::accumulate(mixture.weights.begin(), mixture.weights.end(), 0.0);
  std::vector<FactoredGaussian> gaussians;
  std::vector<double> log_weight;
  for (std::size_t s = 0; s < mixture.size(); ++s) {
    gaussians.emplace_back(mixture.component(s));
    log_weight.push_back(std::log((1 - options.outlier_share) * mixture.weights[s] / total));
  }
  const double outlier = std::log(options.outlier_share / options.outlier_volume);
  std::vector<double> result(points.size());
  parallel_blocks(
      points.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Index> near;
        std::vector<double> terms;
        for (std::size_t i = begin; i < end; ++i) {
          terms.assign(1, outlier);
          search.within(points[i], options.reach, near);
          for (const Index s : near)
            if (squared_mahalanobis(gaussians[s], points[i]) <= options.reach * options.reach)
              terms.push_back(log_weight[s] + log_density(gaussians[s], points[i]));
          result[i] = log_sum_exp(terms);
        }
      },
      512);
  return result;
}

}  // namespace gpsrecon::internal
