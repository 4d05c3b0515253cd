// Principal axes (Hoppe et al. 1992), the spherical median by the iteration of Weiszfeld 1937, and its continuous
// form (CSW, Preiner et al. 2014, section 9, Eq. 31-34).

#include <gpsrecon/clop/normals.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/principal_axes.h>
#include <gpsrecon/core/sym3.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr std::size_t queries_per_block = 1024;

constexpr int fewest_neighbors = 12, most_neighbors = 100;
constexpr double wanted_error = 0.04;         // angle by which noise may turn a plane, radians
constexpr std::size_t scale_samples = 16384;  // a median needs no more neighbourhoods than this
constexpr std::size_t noise_neighbors = 48;   // as many as show noise rather than spacing
constexpr double line_ratio = 0.1 * 0.1;      // of the variances of what is a line
constexpr std::size_t most_doublings = 3;     // of the neighbours of a line

/// Below this angle a Weiszfeld weight 1/d grows no more.
constexpr double smallest_angle = 1e-5;
/// θ(h) = exp(-16): what has less weight than that is out of reach.
constexpr double reach_exponent = 16;

/// 1/d on [0, 1] as a sum of Gaussians ŵ exp(-d²/2σ̂²) (Preiner et al. 2014, Figure 5).
struct KernelTerm {
  double weight, deviation;
};
constexpr std::array<KernelTerm, 3> kernel{
    {{11.4527327, 0.117719940}, {29.8858795, 0.032869803}, {97.7605615, 0.010097481}}};
constexpr double angular_h = std::numbers::pi;

void check_finite(std::span<const Vec3> queries) {
  for (std::size_t i = 0; i < queries.size(); ++i)
    if (!queries[i].allFinite()) throw InvariantError("normals: query " + std::to_string(i) + " is not finite");
}

void refuse_few(std::size_t n) {
  if (n < 3) throw NoSurfaceError("no normals of " + count_of(n, "point"));
}

/// Medians over a regular subset of the points: of the spacing A, from the distance to the farthest of 9 neighbours,
/// and of the thickness of the sheet.
struct Sampling {
  double spacing, noise;
};

Sampling sampling_of(std::span<const Vec3> points, const Neighbors& index, const RunContext& context) {
  constexpr std::size_t spacing_neighbors = 9;
  const std::size_t stride = std::max<std::size_t>(1, points.size() / scale_samples);
  const std::size_t count = (points.size() + stride - 1) / stride;
  std::vector<double> spacings(count), thicknesses(count);
  parallel_blocks(
      count, context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3& center = points[i * stride];
          index.nearest(center, noise_neighbors, near);
          thicknesses[i] =
              std::sqrt(std::max(0.0, eigen_decomposition(local_covariance(points, center, near)).values[0]));
          const std::size_t k = std::min(spacing_neighbors, near.size());
          spacings[i] = near[k - 1].distance * std::sqrt(std::numbers::pi / static_cast<double>(k));
        }
      },
      queries_per_block);
  return {median(spacings), median(thicknesses)};
}

NormalOptions resolve(NormalOptions options, std::span<const Vec3> points, const Neighbors& index,
                      const RunContext& context) {
  if (options.neighbors > 0 && options.h > 0) return options;
  const Sampling sampling = sampling_of(points, index, context);
  if (options.neighbors == 0) {
    // k points on a disc of radius R = A sqrt(k/π) deviate by R/2 along it, and noise ν turns the plane through them by
    // ν / (R/2 sqrt(k)) = 2 sqrt(π) ν / (A k).
    const double turned =
        sampling.spacing > 0 ? 2 * std::sqrt(std::numbers::pi) * sampling.noise / sampling.spacing : 0;
    options.neighbors = static_cast<int>(
        std::clamp(std::ceil(turned / wanted_error), double{fewest_neighbors}, double{most_neighbors}));
  }
  if (options.h == 0) {
    // θ deviates by h/sqrt(32) along each axis: as the neighbours do.
    const double radius = sampling.spacing * std::sqrt(options.neighbors / std::numbers::pi);
    options.h = std::sqrt(8.0) * radius;
  }
  return options;
}

/// Axes with their weights, and the sum of w m mᵀ of which the largest eigenvector is the axis of least squares.
Vec3 mean_axis(std::span<const Vec3> axes, std::span<const double> weights) {
  Sym3 scatter;
  for (std::size_t j = 0; j < axes.size(); ++j) scatter += weights[j] * Sym3::outer(axes[j]);
  return eigen_decomposition(scatter).vectors.col(2);
}

/// The end of the geodesic that leaves n along the tangent vector v.
Vec3 follow_geodesic(const Vec3& n, const Vec3& v) {
  const double angle = v.norm();
  if (angle == 0) return n;
  return (std::cos(angle) * n + std::sin(angle) / angle * v).normalized();
}

/// Moves n to the weighted median of the axes. A step is Σ w u / Σ w/d, u the directions on the sphere towards the axes
/// on the side of n. The chord stands for the angle d, which only scales the step: it is at most a tenth longer then.
Vec3 weiszfeld_median(Vec3 n, std::span<const Vec3> axes, std::span<const double> weights,
                      const NormalOptions& options) {
  for (int step = 0; step < options.iterations; ++step) {
    Vec3 pull = Vec3::Zero();
    double slowness = 0;
    for (std::size_t j = 0; j < axes.size(); ++j) {
      const double cosine = n.dot(axes[j]);
      const Vec3 towards = axes[j] - cosine * n;
      const double sine2 = towards.squaredNorm(), rest = 1 - std::abs(cosine);
      pull += std::copysign(weights[j], cosine) / std::max(std::sqrt(sine2), smallest_angle) * towards;
      slowness += weights[j] / std::max(std::sqrt(sine2 + rest * rest), smallest_angle);
    }
    if (!(slowness > 0)) return n;
    const Vec3 move = pull / slowness;
    n = follow_geodesic(n, move);
    if (move.norm() < options.convergence) break;
  }
  return n;
}

/// A wrapped normal against the terms of the kernel, all centred in some n (Eq. 31): weight and factor t of each.
struct WrappedTerms {
  std::array<double, 3> weight;    ///< w_s ŵ_k σ̂_k² h²/λ_sk, of Eq. 32
  std::array<double, 3> exponent;  ///< 1/(2 λ_sk)
  std::array<double, 3> share;     ///< t of Eq. 34

  WrappedTerms(double component_weight, double total_variance) {
    for (std::size_t k = 0; k < kernel.size(); ++k) {
      const double term = kernel[k].deviation * angular_h * kernel[k].deviation * angular_h;
      // Eq. 30 is the variance of the angle in both directions; that of each is half of it.
      const double lambda = 0.5 * total_variance + term;
      share[k] = term / lambda;
      weight[k] = component_weight * kernel[k].weight * share[k];
      exponent[k] = 0.5 / lambda;
    }
  }
};

/// The components in the reach of a query.
struct Reached {
  std::vector<Index> component;
  std::vector<double> weight;  ///< spatial, the largest is 1
  std::vector<Vec3> axis;

  void clear() {
    component.clear();
    weight.clear();
    axis.clear();
  }
};

/// Finds the components whose Gaussian, widened by θ, reaches a query. Sorted into classes by size, each with its own
/// search tree, so that one huge Gaussian does not make every search a search through all.
class Reach {
 public:
  Reach(const Mixture& mixture, double h, const RunContext& context) : mixture_(mixture) {
    const std::size_t n = mixture.size();
    precision_.resize(n);
    log_scale_.resize(n);
    std::vector<double> radius(n);
    parallel_for(n, context, [&](std::size_t s) {
      const Sym3 widened = mixture.covariances[s] + Sym3::identity(h * h / 32);
      const Cholesky3 factor(widened);
      precision_[s] = factor.inverse();
      log_scale_[s] = -0.5 * factor.log_determinant();
      radius[s] = std::sqrt(2 * reach_exponent * largest_eigenvalue(widened)) * (1 + 1e-6);
    });
    std::map<int, SizeClass> classes;
    std::map<int, std::vector<Vec3>> means;
    for (std::size_t s = 0; s < n; ++s) {
      const int size = std::ilogb(radius[s]);
      SizeClass& c = classes[size];
      c.components.push_back(static_cast<Index>(s));
      c.radius = std::max(c.radius, radius[s]);
      means[size].push_back(mixture.means[s]);
    }
    for (auto& [size, c] : classes) {
      c.index = Neighbors(means[size]);
      classes_.push_back(std::move(c));
    }
  }

  /// Weights are those of Eq. 24 without w_s, over the largest of them.
  void find(const Vec3& query, std::vector<Neighbor>& near, Reached& reached) const {
    reached.clear();
    double largest = -std::numeric_limits<double>::infinity();
    for (const SizeClass& c : classes_) {
      c.index.within(query, c.radius, near);
      for (const Neighbor& neighbor : near) {
        const Index s = c.components[neighbor.index];
        const double exponent = 0.5 * precision_[s].quadratic_form(query - mixture_.means[s]);
        if (!(exponent <= reach_exponent)) continue;
        reached.component.push_back(s);
        reached.weight.push_back(log_scale_[s] - exponent);
        reached.axis.push_back(mixture_.normals[s]);
        largest = std::max(largest, reached.weight.back());
      }
    }
    for (double& weight : reached.weight) weight = std::exp(weight - largest);
  }

  Index nearest(const Vec3& query, std::vector<Neighbor>& near) const {
    Neighbor best{no_index, std::numeric_limits<double>::infinity()};
    for (const SizeClass& c : classes_) {
      c.index.nearest(query, 1, near);
      best = std::min(best, Neighbor{c.components[near.front().index], near.front().distance});
    }
    return best.index;
  }

 private:
  struct SizeClass {
    std::vector<Index> components;
    double radius = 0;
    Neighbors index{{}};
  };
  const Mixture& mixture_;
  std::vector<Sym3> precision_;    ///< of Σ_s + h²/32
  std::vector<double> log_scale_;  ///< ln of the normalising factor
  std::vector<SizeClass> classes_;
};

/// The continuous counterpart of weiszfeld_median (Eq. 31-34): the expectations μ_sk lie on the geodesic towards μ_s,
/// at the share t of its length (Eq. 33).
Vec3 continuous_median(Vec3 n, const Reached& reached, const std::vector<WrappedTerms>& terms,
                       const NormalOptions& options) {
  for (int step = 0; step < options.iterations; ++step) {
    Vec3 pull = Vec3::Zero();
    double total = 0;
    for (std::size_t j = 0; j < reached.component.size(); ++j) {
      const WrappedTerms& wrapped = terms[reached.component[j]];
      const double cosine = n.dot(reached.axis[j]);
      const Vec3 towards = reached.axis[j] - cosine * n;
      const double sine = towards.norm();
      const double angle = std::atan2(sine, std::abs(cosine));
      double weight = 0, moved = 0;
      for (std::size_t k = 0; k < kernel.size(); ++k) {
        const double omega = wrapped.weight[k] * std::exp(-angle * angle * wrapped.exponent[k]);
        weight += omega;
        moved += omega * wrapped.share[k];
      }
      total += reached.weight[j] * weight;
      if (sine > 0) pull += std::copysign(reached.weight[j] * moved * angle / sine, cosine) * towards;
    }
    if (!(total > 0)) return n;
    const Vec3 move = pull / total;
    n = follow_geodesic(n, move);
    if (move.norm() < options.convergence) break;
  }
  return n;
}

/// From the extent of the Gaussians: the kernel is as wide as the median one is along its sheet.
double automatic_h(const Mixture& mixture, const RunContext& context) {
  std::vector<double> extent(mixture.size());
  parallel_for(mixture.size(), context, [&](std::size_t s) {
    extent[s] = std::sqrt(std::max(0.0, eigen_decomposition(mixture.covariances[s]).values[1]));
  });
  return std::sqrt(32.0) * median(extent);
}

}  // namespace

void NormalOptions::check() const {
  check_fields(*this);
  // Squares of h must not overflow.
  if (!(h >= 0 && h <= 1e100)) throw OptionError("h must be in (0, 1e100] or 0, not " + to_text(h));
}

NormalOptions resolve(NormalOptions options, std::span<const Vec3> points, const RunContext& context) {
  options.check();
  refuse_few(points.size());
  return resolve(options, points, Neighbors(points), context);
}

std::vector<Vec3> pca_normals(std::span<const Vec3> queries, std::span<const Vec3> points, const NormalOptions& given,
                              const RunContext& context) {
  given.check();
  check_finite(queries);
  refuse_few(points.size());
  if (on_a_line(points)) throw NoSurfaceError("all points lie on a line: no normals");
  const Neighbors index(points);
  const auto k = static_cast<std::size_t>(resolve(given, points, index, context).neighbors);
  std::vector<Vec3> normals(queries.size());
  parallel_blocks(
      queries.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t i = begin; i < end; ++i) {
          Eigen3 axes;
          for (std::size_t doublings = 0; doublings <= most_doublings; ++doublings) {
            index.nearest(queries[i], k << doublings, near);
            axes = eigen_decomposition(local_covariance(points, queries[i], near));
            if (axes.values[1] > line_ratio * axes.values[2] || near.size() == points.size()) break;
          }
          normals[i] = axes.vectors.col(0);
        }
      },
      queries_per_block);
  return normals;
}

std::vector<Vec3> weiszfeld_normals(std::span<const Vec3> queries, const PointCloud& cloud, const NormalOptions& given,
                                    const RunContext& context) {
  given.check();
  check_finite(queries);
  if (cloud.empty()) throw InputError("normals: there are no points");
  if (cloud.normals.size() != cloud.size()) throw InputError("normals: the points have no normals to take medians of");
  const Neighbors index(cloud.positions);
  if (given.h == 0) refuse_few(cloud.size());
  const bool automatic = given.h == 0;
  const NormalOptions options = automatic ? resolve(given, cloud.positions, index, context) : given;
  std::vector<Vec3> normals(queries.size());
  parallel_blocks(
      queries.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        std::vector<Vec3> axes;
        std::vector<double> weights;
        for (std::size_t i = begin; i < end; ++i) {
          double h = options.h;
          if (automatic) {
            // Where points are dense the kernel is narrower, or they would be too many.
            index.nearest(queries[i], static_cast<std::size_t>(options.neighbors), near);
            h = std::min(h, std::sqrt(8.0) * near.back().distance);
          }
          index.within(queries[i], h, near);
          if (near.empty()) index.nearest(queries[i], 1, near);
          axes.clear();
          weights.clear();
          for (const Neighbor& neighbor : near) {
            const Vec3& normal = cloud.normals[neighbor.index];
            const double length = normal.norm();
            if (!(length > 0) || !std::isfinite(length)) continue;
            // Only the nearest of all points can be farther than h, which is zero where the spacing is.
            const double r = neighbor.distance < h ? 4 * neighbor.distance / h : neighbor.distance > 0 ? 4 : 0;
            axes.push_back(normal / length);
            weights.push_back(cloud.weight(neighbor.index) * std::exp(-r * r));
          }
          normals[i] = weiszfeld_median(mean_axis(axes, weights), axes, weights, given);
        }
      },
      queries_per_block);
  return normals;
}

std::vector<Vec3> csw_normals(std::span<const Vec3> queries, const Mixture& mixture, const NormalOptions& options,
                              const RunContext& context) {
  options.check();
  check_finite(queries);
  if (mixture.empty()) throw InputError("normals: the mixture has no components");
  if (mixture.normals.size() != mixture.size() || mixture.normal_variances.size() != mixture.size())
    throw InputError("normals: the mixture has no normals (columns nvx nvy nvz)");
  const double h = options.h > 0 ? options.h : automatic_h(mixture, context);
  const Reach reach(mixture, h, context);
  std::vector<WrappedTerms> terms;
  terms.reserve(mixture.size());
  for (std::size_t s = 0; s < mixture.size(); ++s) terms.emplace_back(mixture.weights[s], mixture.normal_variances[s]);
  std::vector<Vec3> normals(queries.size());
  parallel_blocks(
      queries.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        Reached reached;
        std::vector<double> weights;
        for (std::size_t i = begin; i < end; ++i) {
          reach.find(queries[i], near, reached);
          if (reached.component.empty()) {
            normals[i] = mixture.normals[reach.nearest(queries[i], near)];
            continue;
          }
          weights.clear();
          for (std::size_t j = 0; j < reached.component.size(); ++j)
            weights.push_back(reached.weight[j] * mixture.weights[reached.component[j]]);
          normals[i] = continuous_median(mean_axis(reached.axis, weights), reached, terms, options);
        }
      },
      queries_per_block);
  return normals;
}

}  // namespace gpsrecon
