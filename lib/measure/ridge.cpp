// Ridges of a density: Ozertem & Erdogmus 2011, of Preiner et al. 2019, section 2.1.

#include "ridge.h"

#include <gpsrecon/core/component_search.h>
#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace gpsrecon::internal {
namespace {

/// A mixture, ready to be evaluated.
struct Density {
  std::vector<FactoredGaussian> gaussians;
  std::vector<double> log_weights;
  ComponentSearch search;

  explicit Density(const Mixture& mixture) : search(mixture) {
    gaussians.reserve(mixture.size());
    for (std::size_t s = 0; s < mixture.size(); ++s) {
      gaussians.emplace_back(mixture.component(s));
      log_weights.push_back(std::log(mixture.weights[s]));
    }
  }
};

/// The components around a point that stay those that matter while it moves by no more than `margin`.
class Surrounding {
 public:
  Surrounding(const Density& density, double reach)
      : density_(density), reach_(reach), margin_(density.search.finest_deviation()) {}

  const std::vector<Index>& components(const Vec3& x) {
    if (!((x - anchor_).norm() <= margin_)) {
      density_.search.within(x, reach_, components_, margin_);
      anchor_ = x;
    }
    return components_;
  }

 private:
  const Density& density_;
  double reach_, margin_;
  Vec3 anchor_ = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<Index> components_;
};

/// ln f about a point.
struct LocalDensity {
  bool empty = true;             ///< no component is within reach
  Vec3 gradient = Vec3::Zero();  ///< g = Σ r_i a_i, a_i = Σ_i⁻¹ (μ_i - x)
  Sym3 mean_precision{};         ///< M = Σ r_i Σ_i⁻¹
  Sym3 curvature{};              ///< -∇∇ᵀ ln f = M - Σ r_i a_i a_iᵀ + g gᵀ
};

LocalDensity evaluate(const Density& density, const std::vector<Index>& components, const Vec3& x,
                      std::vector<double>& terms) {
  LocalDensity local;
  if (components.empty()) return local;
  local.empty = false;
  terms.clear();
  for (const Index s : components) terms.push_back(density.log_weights[s] + log_density(density.gaussians[s], x));
  // The largest factored out, so that the responsibilities are defined where all densities underflow.
  const double largest = *std::max_element(terms.begin(), terms.end());
  double total = 0;
  for (double& t : terms) total += t = std::exp(t - largest);
  Sym3 spread{};
  for (std::size_t k = 0; k < components.size(); ++k) {
    const double r = terms[k] / total;
    if (r == 0) continue;
    const FactoredGaussian& g = density.gaussians[components[k]];
    const Vec3 a = g.precision * (g.mean - x);
    local.gradient += r * a;
    local.mean_precision += r * g.precision;
    spread += r * Sym3::outer(a);
  }
  local.curvature = local.mean_precision - spread + Sym3::outer(local.gradient);
  return local;
}

RidgePoint climb(const Density& density, const Vec3& start, const RidgeOptions& options, std::vector<double>& terms) {
  Surrounding surrounding(density, options.reach);
  RidgePoint point{start, Vec3::Zero(), false};
  for (int step = 0; step < options.max_steps; ++step) {
    const LocalDensity local = evaluate(density, surrounding.components(point.position), point.position, terms);
    if (local.empty) return point;
    const Eigen3 curvature = eigen_decomposition(local.curvature);
    point.across = curvature.vectors.col(2);
    const double precision = local.mean_precision.quadratic_form(point.across);
    const double length = point.across.dot(local.gradient) / precision;
    point.position += length * point.across;
    if (std::abs(length) * std::sqrt(precision) <= options.tolerance) {
      point.on_ridge = curvature.values[2] > 0;
      return point;
    }
  }
  return point;
}

}  // namespace

void RidgeOptions::check() const {
  const auto fail = [](const char* field, const char* range, double value) {
    throw OptionError(std::string(field) + " must be " + range + ", not " + std::to_string(value));
  };
  if (max_steps < 1 || max_steps > 100000) fail("max_steps", "in [1, 100000]", max_steps);
  if (!(tolerance > 0 && tolerance <= 0.1)) fail("tolerance", "in (0, 0.1]", tolerance);
  if (!(reach >= 3 && reach <= 30)) fail("reach", "in [3, 30]", reach);
}

std::vector<RidgePoint> project_to_ridge(const Mixture& mixture, std::span<const Vec3> points,
                                         const RidgeOptions& options, const RunContext& context) {
  options.check();
  if (mixture.empty()) throw InvariantError("an empty mixture has no ridge");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite()) throw InvariantError("point " + std::to_string(i) + " is not finite");
  const Density density(mixture);
  std::vector<RidgePoint> found(points.size());
  parallel_blocks(
      points.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<double> terms;
        for (std::size_t i = begin; i < end; ++i) found[i] = climb(density, points[i], options, terms);
      },
      128);
  return found;
}

RidgeDistance ridge_distance(std::span<const Vec3> points, std::span<const RidgePoint> found,
                             const RunContext& context) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (found[i].on_ridge) distances.push_back((found[i].position - points[i]).norm());
  return {statistics(distances, {}, context), points.size() - distances.size()};
}

}  // namespace gpsrecon::internal
