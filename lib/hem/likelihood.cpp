#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/hem/likelihood.h>
#include <cmath>
#include <map>
#include <numeric>
#include <string>

namespace gpsrecon {
namespace {

/// Components whose largest deviations lie within a factor of two, so that one search radius suits all of them: with
/// the largest of the whole mixture a single wide Gaussian would make every search long.
struct SizeClass {
  std::vector<Index> components;
  double largest_deviation = 0;
  Neighbors index{{}};
};

std::vector<SizeClass> size_classes(const Mixture& mixture) {
  std::map<int, SizeClass> by_exponent;
  for (Index s = 0; s < mixture.size(); ++s) {
    const double deviation = std::sqrt(largest_eigenvalue(mixture.covariances[s]));
    SizeClass& c = by_exponent[std::ilogb(deviation)];
    c.components.push_back(s);
    c.largest_deviation = std::max(c.largest_deviation, deviation);
  }
  std::vector<SizeClass> classes;
  for (auto& [exponent, c] : by_exponent) {
    std::vector<Vec3> means;
    for (const Index s : c.components) means.push_back(mixture.means[s]);
    c.index = Neighbors(means);
    classes.push_back(std::move(c));
  }
  return classes;
}

/// ln Σ exp(terms), the largest factored out.
double log_sum_exp(const std::vector<double>& terms) {
  const double largest = *std::max_element(terms.begin(), terms.end());
  double sum = 0;
  for (const double t : terms) sum += std::exp(t - largest);
  return largest + std::log(sum);
}

}  // namespace

void LikelihoodOptions::check() const {
  const auto fail = [](const char* field, const char* range, double value) {
    throw OptionError(std::string(field) + " must be " + range + ", not " + std::to_string(value));
  };
  if (!(outlier_share > 0 && outlier_share < 1)) fail("outlier_share", "in (0, 1)", outlier_share);
  if (!(outlier_volume > 0) || !std::isfinite(outlier_volume)) fail("outlier_volume", "positive", outlier_volume);
  if (!(reach > 0) || !std::isfinite(reach)) fail("reach", "positive", reach);
}

std::vector<double> log_likelihoods(const Mixture& mixture, std::span<const Vec3> points,
                                    const LikelihoodOptions& options, const RunContext& context) {
  options.check();
  if (mixture.empty()) throw InvariantError("no likelihood under an empty mixture");
  const std::vector<SizeClass> classes = size_classes(mixture);
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
        std::vector<Neighbor> near;
        std::vector<double> terms;
        for (std::size_t i = begin; i < end; ++i) {
          terms.assign(1, outlier);
          for (const SizeClass& c : classes) {
            c.index.within(points[i], options.reach * c.largest_deviation, near);
            for (const Neighbor& n : near) {
              const Index s = c.components[n.index];
              if (squared_mahalanobis(gaussians[s], points[i]) <= options.reach * options.reach)
                terms.push_back(log_weight[s] + log_density(gaussians[s], points[i]));
            }
          }
          result[i] = log_sum_exp(terms);
        }
      },
      512);
  return result;
}

}  // namespace gpsrecon
