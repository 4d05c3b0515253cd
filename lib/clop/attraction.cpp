#include <gpsrecon/clop/attraction.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>

namespace gpsrecon {
namespace {

/// 1/Σ w_k of the published fit: α̂(0) in support radii.
constexpr double least_distance = 1 / 139.1;

/// Variance of θ as a Gaussian, in h² (Preiner et al. 2014, section 6.2).
constexpr double theta_variance = 1.0 / 32;

/// Where a weight of exp(-½ d²/(λ + σ²)) has fallen to e^-10, in standard deviations.
constexpr double tail_deviations = 4.4721359549995794;

/// Sums of squares smaller than this have lost their digits to underflow: nothing is really in reach.
constexpr double least_weight = 1e-280;

/// Density of the points around each, v_j = Σ w_j' θ(|p_j - p_j'|), itself included (Huang et al. 2009).
std::vector<double> densities(const PointCloud& points, const Neighbors& index, double h, const RunContext& context) {
  std::vector<double> density(points.size());
  parallel_blocks(
      points.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t j = begin; j < end; ++j) {
          index.within(points.positions[j], h, near);
          double sum = 0;
          for (const Neighbor& n : near) sum += points.weight(n.index) * theta(n.distance / h);
          density[j] = sum;
        }
      },
      512);
  return density;
}

}  // namespace

PointAttraction::PointAttraction(const PointCloud& points, double support_radius, bool balance,
                                 const RunContext& context)
    : points_(points.positions), h_(support_radius), index_(points.positions), weights_(points.weights) {
  if (weights_.empty()) weights_.assign(points.size(), 1.0);
  if (!balance) return;
  const std::vector<double> density = densities(points, index_, h_, context);
  for (std::size_t j = 0; j < weights_.size(); ++j) weights_[j] /= density[j];
}

std::optional<Vec3> PointAttraction::pull(const Vec3& q, ProjectionStep step, std::vector<Neighbor>& near) const {
  index_.within(q, h_, near);
  double total = 0;
  Vec3 shift = Vec3::Zero();
  for (const Neighbor& n : near) {
    const double r = n.distance / h_;
    const double kernel = step == ProjectionStep::mean ? theta(r) : theta(r) / std::max(r, least_distance);
    const double w = weights_[n.index] * kernel;
    total += w;
    shift += w * (points_[n.index] - q);
  }
  if (!(total > 0)) return std::nullopt;
  return shift / total;
}

/// Weight and weighted step of the products met so far, Eq. 18.
template <std::size_t K>
struct MixtureAttraction::Pull {
  double total = 0;
  Vec3 shift = Vec3::Zero();

  /// Nothing need be subtracted from the exponents: where the ellipsoid reaches the ball, the exponent of the widest
  /// Gaussian of the kernel is at most ½ (1/σ_1 + m)², far from where exp() underflows.
  void add(const Vec3& d, const Products<K>& products, const std::array<double, K>& half_precision) {
    for (std::size_t k = 0; k < K; ++k) {
      const Vec3 step = products[k].gain * d;
      const double w = products[k].weight * std::exp(-half_precision[k] * d.dot(step));
      total += w;
      shift += w * step;
    }
  }
};

MixtureAttraction::MixtureAttraction(const Mixture& mixture, double support_radius, const KernelFit& kernel,
                                     const RunContext& context)
    : h_(support_radius) {
  const double h2 = h_ * h_;
  std::array<double, 3> variance;
  for (std::size_t k = 0; k < 3; ++k) {
    variance[k] = kernel.deviation[k] * kernel.deviation[k] * h2;
    half_precision_[k] = 0.5 / variance[k];
  }
  const double mean_variance = theta_variance * h2;
  mean_half_precision_[0] = 0.5 / mean_variance;

  // Octaves of the largest deviation, all below an eighth of h in one: few groups, and no wide component widens the
  // search for all others.
  const std::size_t n = mixture.size();
  std::vector<int> octave(n);
  std::vector<double> deviation(n);
  parallel_for(n, context, [&](std::size_t s) {
    deviation[s] = std::sqrt(std::max(0.0, eigen_decomposition(mixture.covariances[s]).values[2]));
    octave[s] = std::max(0, static_cast<int>(std::ceil(std::log2(std::max(1.0, 8 * deviation[s] / h_)))));
  });
  const int octaves = n == 0 ? 0 : *std::max_element(octave.begin(), octave.end()) + 1;

  const auto product = [&](std::size_t s, double kernel_weight, double kernel_variance) {
    // ω = w ŵ |σ²h² Λ⁻¹|^½ exp(...): the gain is computed once and its determinant with it.
    const Sym3 gain = kernel_variance * Cholesky3(mixture.covariances[s] + Sym3::identity(kernel_variance)).inverse();
    return Product{gain, mixture.weights[s] * kernel_weight * std::sqrt(gain.determinant())};
  };
  for (int o = 0; o < octaves; ++o) {
    std::vector<Index> members;
    double widest = 0;
    for (std::size_t s = 0; s < n; ++s)
      if (octave[s] == o) members.push_back(static_cast<Index>(s)), widest = std::max(widest, deviation[s]);
    if (members.empty()) continue;
    std::vector<Vec3> means(members.size());
    std::vector<Products<3>> median(members.size());
    std::vector<Products<1>> mean(members.size());
    parallel_for(members.size(), context, [&](std::size_t m) {
      const Index s = members[m];
      means[m] = mixture.means[s];
      for (std::size_t k = 0; k < 3; ++k) median[m][k] = product(s, kernel.weight[k], variance[k]);
      mean[m][0] = product(s, 1, mean_variance);
    });
    const double reach =
        std::max(h_ + widest, tail_deviations * std::sqrt(widest * widest + std::max(variance[0], mean_variance)));
    Neighbors index(means);
    groups_.push_back({reach, std::move(means), std::move(median), std::move(mean), std::move(index)});
  }
}

std::optional<Vec3> MixtureAttraction::pull(const Vec3& q, ProjectionStep step, std::vector<Neighbor>& near) const {
  const auto over_groups = [&](auto pull, const auto& products, const auto& half_precision) -> std::optional<Vec3> {
    for (const Group& group : groups_) {
      group.index.within(q, group.reach, near);
      for (const Neighbor& n : near) pull.add(group.means[n.index] - q, products(group)[n.index], half_precision);
    }
    if (!(pull.total > least_weight)) return std::nullopt;
    return pull.shift / pull.total;
  };
  if (step == ProjectionStep::mean)
    return over_groups(
        Pull<1>(), [](const Group& g) -> const auto& { return g.mean; }, mean_half_precision_);
  return over_groups(
      Pull<3>(), [](const Group& g) -> const auto& { return g.median; }, half_precision_);
}

}  // namespace gpsrecon
