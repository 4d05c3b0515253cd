// The attraction of continuous LOP: Preiner et al. 2014, section 6, Eq. 14 and 18-21; of WLOP: Huang et al. 2009.

#include <gpsrecon/clop/attraction.h>
#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>

namespace gpsrecon::internal {
namespace {

/// 1/Σ w_k of the published fit: α̂(0) in support radii.
constexpr double least_distance = 1 / 139.1;

/// Variance of θ as a Gaussian, in h² (Preiner et al. 2014, section 6.2).
constexpr double theta_variance = 1.0 / 32;

/// Where a weight of exp(-½ d²/(λ + σ²)) has fallen to e^-10, in standard deviations.
constexpr double tail_deviations = 4.4721359549995794;

/// Sums of squares smaller than this have lost their digits to underflow: nothing is really in reach.
constexpr double least_weight = 1e-280;

/// Particles that share a search for Gaussians.
constexpr std::size_t max_shared = 8;

struct Ball {
  Vec3 center;
  double radius;
};

Ball enclosing_ball(std::span<const Vec3> points) {
  Ball ball{bounding_box(points).center(), 0};
  for (const Vec3& p : points) ball.radius = std::max(ball.radius, (p - ball.center).norm());
  ball.radius *= 1 + 1e-12;  // what lies on it must be found
  return ball;
}

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

void PointAttraction::pull(std::span<const Vec3> particles, ProjectionStep step, std::vector<Neighbor>& near,
                           std::span<std::optional<Vec3>> pulls) const {
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Vec3& q = particles[i];
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
    pulls[i] = total > 0 ? std::optional<Vec3>(shift / total) : std::nullopt;
  }
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

  // Half octaves of the largest deviation, all below an eighth of h in one: few groups, and no wide component widens
  // the search for all others.
  const std::size_t n = mixture.size();
  std::vector<int> extent_class(n);
  std::vector<double> deviation(n);
  parallel_for(n, context, [&](std::size_t s) {
    deviation[s] = std::sqrt(std::max(0.0, eigen_decomposition(mixture.covariances[s]).values[2]));
    const double extent = std::clamp(8 * deviation[s] / h_, 1.0, 1e9);
    extent_class[s] = static_cast<int>(std::ceil(2 * std::log2(extent)));
  });
  const int classes = n == 0 ? 0 : *std::max_element(extent_class.begin(), extent_class.end()) + 1;

  const auto product = [&](std::size_t s, double kernel_weight, double kernel_variance) {
    // ω = w ŵ |σ²h² Λ⁻¹|^½ exp(...): the gain is computed once and its determinant with it.
    const Sym3 gain = kernel_variance * Cholesky3(mixture.covariances[s] + Sym3::identity(kernel_variance)).inverse();
    return Product{gain, mixture.weights[s] * kernel_weight * std::sqrt(gain.determinant())};
  };
  for (int o = 0; o < classes; ++o) {
    std::vector<Index> members;
    for (std::size_t s = 0; s < n; ++s)
      if (extent_class[s] == o) members.push_back(static_cast<Index>(s));
    if (members.empty()) continue;
    std::vector<Vec3> means(members.size());
    std::vector<Center> centers(members.size());
    std::vector<Products<3>> median(members.size());
    std::vector<Products<1>> mean(members.size());
    parallel_for(members.size(), context, [&](std::size_t m) {
      const Index s = members[m];
      means[m] = mixture.means[s];
      const double reach =
          std::max(h_ + deviation[s], tail_deviations * std::sqrt(deviation[s] * deviation[s] + variance[0]));
      centers[m] = {means[m], reach * reach};
      for (std::size_t k = 0; k < 3; ++k) median[m][k] = product(s, kernel.weight[k], variance[k]);
      mean[m][0] = product(s, 1, mean_variance);
    });
    double reach2 = 0;
    for (const Center& center : centers) reach2 = std::max(reach2, center.squared_reach);
    Neighbors index(means);
    groups_.push_back({std::sqrt(reach2), std::move(centers), std::move(median), std::move(mean), std::move(index)});
  }
}

/// One search serves all particles, as they are few and close: the ball around them, widened by the reach, holds what
/// is in reach of any. A Gaussian still counts for those it reaches only, as if each had searched alone.
template <std::size_t K>
void MixtureAttraction::pull(std::span<const Vec3> particles, const std::array<double, K>& half_precision,
                             std::vector<Products<K>> Group::*products, std::vector<Neighbor>& near,
                             std::span<std::optional<Vec3>> pulls) const {
  const Ball ball = enclosing_ball(particles);
  if (particles.size() > 1 && ball.radius > h_) {  // not close: the search would find too much
    const std::size_t half = particles.size() / 2;
    pull(particles.first(half), half_precision, products, near, pulls.first(half));
    pull(particles.subspan(half), half_precision, products, near, pulls.subspan(half));
    return;
  }
  std::array<Pull<K>, max_shared> sums{};
  for (const Group& group : groups_) {
    group.index.within(ball.center, ball.radius + group.reach, near);
    for (const Neighbor& n : near) {
      const Center& center = group.centers[n.index];
      const Products<K>& product = (group.*products)[n.index];
      for (std::size_t i = 0; i < particles.size(); ++i) {
        const Vec3 d = center.mean - particles[i];
        if (d.squaredNorm() <= center.squared_reach) sums[i].add(d, product, half_precision);
      }
    }
  }
  for (std::size_t i = 0; i < particles.size(); ++i)
    pulls[i] = sums[i].total > least_weight ? std::optional<Vec3>(sums[i].shift / sums[i].total) : std::nullopt;
}

void MixtureAttraction::pull(std::span<const Vec3> particles, ProjectionStep step, std::vector<Neighbor>& near,
                             std::span<std::optional<Vec3>> pulls) const {
  for (std::size_t begin = 0; begin < particles.size(); begin += max_shared) {
    const std::size_t count = std::min(max_shared, particles.size() - begin);
    if (step == ProjectionStep::mean)
      pull(particles.subspan(begin, count), mean_half_precision_, &Group::mean, near, pulls.subspan(begin, count));
    else
      pull(particles.subspan(begin, count), half_precision_, &Group::median, near, pulls.subspan(begin, count));
  }
}

}  // namespace gpsrecon::internal
