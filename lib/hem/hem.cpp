// Hierarchical expectation maximisation: Preiner et al. 2014, section 5 and Algorithm 1; Preiner et al. 2019,
// appendix A. Wrapped normals: Preiner et al. 2014, section 9.2.

#include <gpsrecon/hem/hem.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/estimate_scale.h>
#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/hem/attributes.h>
#include <gpsrecon/hem/initial_mixture.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr double covariance_floor = 1e-6;       // smallest eigenvalue, relative to the largest
constexpr std::size_t parents_per_block = 256;  // each holds the list of its children, so blocks are small

/// Who may be merged into whom: for parent number s the children are child[offset[s] .. offset[s + 1]).
struct Candidates {
  std::vector<Index> parents;   ///< components drawn as parents, ascending
  std::vector<char> is_parent;  ///< per component
  std::vector<std::size_t> offset;
  std::vector<Index> child;            ///< component
  std::vector<double> log_likelihood;  ///< ln(w_s L_is); later the responsibility r_is
  std::size_t orphans = 0;             ///< components that are no parent and that no parent lists
  std::vector<char> listed;            ///< per component: some parent lists it

  std::size_t next_size() const { return parents.size() + orphans; }
};

/// Step 1: every component is a parent with the given probability. The stream is the level, the counter the component.
void draw_parents(Candidates& c, std::size_t n, double probability, int level, std::uint64_t seed) {
  c.is_parent.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (random_uniform(seed, static_cast<std::uint64_t>(level), i) >= probability) continue;
    c.is_parent[i] = 1;
    c.parents.push_back(static_cast<Index>(i));
  }
}

/// Which components may merge.
struct MergeRule {
  double alpha;
  bool within_flat = false;
};

/// How far, of the smallest eigenvalue of the parent, a child may lie off its plane and be thicker, both as variances.
constexpr double flatness = 0.1;

/// Whether the child, `shift` away, would bend or thicken the parent with these axes.
bool bends(const Eigen3& axes, const Vec3& shift, const Sym3& child) {
  const Vec3 normal = axes.vectors.col(0);
  const double off = normal.dot(shift);
  return off * off > flatness * axes.values[0] || child.quadratic_form(normal) > (1 + flatness) * axes.values[0];
}

/// Components with fewer others around them are of a piece so small that it might not remain a surface: three make one.
constexpr std::size_t fewest_around = 3;
/// In standard deviations along the longest axis: farther than any overlap.
constexpr double around = 6;

/// Steps 2 and 3: the components within reach of each parent, and their log-likelihoods (Preiner et al. 2014, Eq. 9,
/// 11; Preiner et al. 2019, appendix A). Since tr(S) - 3 - ln|S| >= 0 for every S = Σs⁻¹Σi, D_KL <= α²/2 implies a
/// Mahalanobis distance of at most α, so the ball of radius α sqrt(λmax(Σs)) holds all children.
void list_children(Candidates& c, const Mixture& level, const MergeRule& rule, const RunContext& context) {
  const double alpha = rule.alpha;
  const std::size_t n = level.size();
  std::vector<double> log_determinant(n);
  parallel_for(n, context,
               [&](std::size_t i) { log_determinant[i] = Cholesky3(level.covariances[i]).log_determinant(); });

  std::vector<Index> others;
  std::vector<Vec3> other_means;
  others.reserve(n - c.parents.size());
  other_means.reserve(n - c.parents.size());
  for (std::size_t i = 0; i < n; ++i) {
    if (c.is_parent[i]) continue;
    others.push_back(static_cast<Index>(i));
    other_means.push_back(level.means[i]);
  }
  const Neighbors index(other_means);
  const Neighbors all(rule.within_flat ? std::span<const Vec3>(level.means) : std::span<const Vec3>());

  struct Block {
    std::vector<Index> child;
    std::vector<double> log_likelihood;
  };
  const std::size_t parent_count = c.parents.size();
  std::vector<Block> blocks((parent_count + parents_per_block - 1) / parents_per_block);
  std::vector<std::size_t> count(parent_count);
  const double log_2pi = 1.5 * std::log(2 * std::numbers::pi);
  parallel_blocks(
      parent_count, context,
      [&](std::size_t block, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        Block& out = blocks[block];
        for (std::size_t p = begin; p < end; ++p) {
          const Index s = c.parents[p];
          const Sym3& covariance = level.covariances[s];
          const Sym3 precision = Cholesky3(covariance).inverse();
          const double log_weight = std::log(level.weights[s]);
          const Eigen3 axes = rule.within_flat ? eigen_decomposition(covariance) : Eigen3{};
          const double deviation = std::sqrt(largest_eigenvalue(covariance));
          if (rule.within_flat) {
            all.within(level.means[s], around * deviation, near);
            if (near.size() <= fewest_around) continue;  // the parent itself is one of them
          }
          index.within(level.means[s], alpha * deviation, near);
          const std::size_t before = out.child.size();
          for (const Neighbor& neighbor : near) {
            const Index i = others[neighbor.index];
            const Vec3 shift = level.means[i] - level.means[s];
            const double expectation = expected_squared_mahalanobis(precision, shift, level.covariances[i]);
            const double divergence = kl_divergence(expectation, log_determinant[i], log_determinant[s]);
            if (!(divergence <= 0.5 * alpha * alpha)) continue;
            if (rule.within_flat && bends(axes, shift, level.covariances[i])) continue;
            out.child.push_back(i);
            out.log_likelihood.push_back(log_weight +
                                         level.weights[i] * (-log_2pi - 0.5 * (log_determinant[s] + expectation)));
          }
          count[p] = out.child.size() - before;
        }
      },
      parents_per_block);

  c.offset.assign(parent_count + 1, 0);
  for (std::size_t p = 0; p < parent_count; ++p) c.offset[p + 1] = c.offset[p] + count[p];
  c.child.reserve(c.offset.back());
  c.log_likelihood.reserve(c.offset.back());
  for (Block& block : blocks) {
    c.child.insert(c.child.end(), block.child.begin(), block.child.end());
    c.log_likelihood.insert(c.log_likelihood.end(), block.log_likelihood.begin(), block.log_likelihood.end());
    block = {};
  }
  c.listed.assign(n, 0);
  for (const Index i : c.child) c.listed[i] = 1;
  c.orphans = 0;
  for (std::size_t i = 0; i < n; ++i) c.orphans += !c.is_parent[i] && !c.listed[i] ? 1 : 0;
}

Candidates find_candidates(const Mixture& level, double probability, const MergeRule& rule, int number,
                           const RunContext& context) {
  Candidates c;
  draw_parents(c, level.size(), probability, number, context.seed);
  list_children(c, level, rule, context);
  return c;
}

/// Step 4: responsibilities over all parents that list a child, r_is = softmax_s ln(w_s L_is). Two passes with the
/// maximum subtracted: in the log domain the result does not depend on units.
void responsibilities(Candidates& c, std::size_t n) {
  std::vector<double> maximum(n, -std::numeric_limits<double>::infinity());
  for (std::size_t e = 0; e < c.child.size(); ++e)
    maximum[c.child[e]] = std::max(maximum[c.child[e]], c.log_likelihood[e]);
  std::vector<double> sum(n, 0.0);
  for (std::size_t e = 0; e < c.child.size(); ++e) {
    c.log_likelihood[e] = std::exp(c.log_likelihood[e] - maximum[c.child[e]]);
    sum[c.child[e]] += c.log_likelihood[e];
  }
  for (std::size_t e = 0; e < c.child.size(); ++e) c.log_likelihood[e] /= sum[c.child[e]];
}

/// Step 5 for one parent: moments of its children and itself (Preiner et al. 2014, Eq. 10), and of their wrapped
/// normals (Eq. 29-30), whose axes are first turned to the parent's side.
void merge_children(const Mixture& level, const Candidates& c, std::size_t p, Mixture& next, std::size_t slot) {
  const Index s = c.parents[p];
  const Vec3& origin = level.means[s];  // moments about the parent's mean lose nothing to its position
  double weight = level.weights[s];
  Vec3 shift = Vec3::Zero();
  for (std::size_t e = c.offset[p]; e < c.offset[p + 1]; ++e) {
    const double w = c.log_likelihood[e] * level.weights[c.child[e]];
    weight += w;
    shift += w * (level.means[c.child[e]] - origin);
  }
  shift /= weight;
  Sym3 covariance = level.weights[s] / weight * (level.covariances[s] + Sym3::outer(shift));
  for (std::size_t e = c.offset[p]; e < c.offset[p + 1]; ++e) {
    const Index i = c.child[e];
    const double share = c.log_likelihood[e] * level.weights[i] / weight;
    covariance += share * (level.covariances[i] + Sym3::outer(level.means[i] - origin - shift));
  }
  next.weights[slot] = weight;
  next.means[slot] = origin + shift;
  next.covariances[slot] = floor_eigenvalues(covariance, covariance_floor);

  if (!level.kernels.empty()) {
    double variance = level.weights[s] * level.kernels[s] * level.kernels[s];
    for (std::size_t e = c.offset[p]; e < c.offset[p + 1]; ++e) {
      const Index i = c.child[e];
      variance += c.log_likelihood[e] * level.weights[i] * level.kernels[i] * level.kernels[i];
    }
    next.kernels[slot] = std::sqrt(variance / weight);
  }
  if (!level.outward.empty()) {
    Vec3 outward = level.weights[s] * level.outward[s];
    for (std::size_t e = c.offset[p]; e < c.offset[p + 1]; ++e)
      outward += c.log_likelihood[e] * level.weights[c.child[e]] * level.outward[c.child[e]];
    next.outward[slot] = outward / weight;
  }
  if (level.normals.empty()) return;
  const Vec3& axis = level.normals[s];
  Vec3 mean_axis = level.weights[s] / weight * axis;
  double variance = level.weights[s] / weight * level.normal_variances[s];
  for (std::size_t e = c.offset[p]; e < c.offset[p + 1]; ++e) {
    const Index i = c.child[e];
    const double share = c.log_likelihood[e] * level.weights[i] / weight;
    mean_axis += (level.normals[i].dot(axis) < 0 ? -share : share) * level.normals[i];
    variance += share * level.normal_variances[i];
  }
  const double resultant = std::min(1.0, mean_axis.norm());
  next.normals[slot] = mean_axis.normalized();
  next.normal_variances[slot] = variance - 2 * std::log(resultant);
}

/// The next level: parents with their children merged and orphans as they are, in the order of the components they
/// came from, which keeps neighbours in space close in memory.
Mixture next_level(const Mixture& level, const Candidates& c, const RunContext& context) {
  const std::size_t n = level.size();
  std::vector<Index> kept;
  std::vector<Index> slot_of_parent(c.parents.size());
  kept.reserve(c.next_size());
  for (std::size_t i = 0, p = 0; i < n; ++i) {
    if (c.is_parent[i]) slot_of_parent[p++] = static_cast<Index>(kept.size());
    if (c.is_parent[i] || !c.listed[i]) kept.push_back(static_cast<Index>(i));
  }
  Mixture next = select(level, kept);
  parallel_for(
      c.parents.size(), context, [&](std::size_t p) { merge_children(level, c, p, next, slot_of_parent[p]); },
      parents_per_block);
  return next;
}

/// Follows every point to the component of the next level that takes the largest share of the one it belongs to.
void follow_points(std::vector<Index>& component_of, const Candidates& c, std::size_t n) {
  std::vector<Index> heir(n);
  Index slot = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (c.is_parent[i] || !c.listed[i]) heir[i] = slot++;
  std::vector<double> largest(n, 0.0);
  for (std::size_t p = 0; p < c.parents.size(); ++p)
    for (std::size_t e = c.offset[p]; e < c.offset[p + 1]; ++e) {
      const Index i = c.child[e];
      if (c.log_likelihood[e] <= largest[i]) continue;
      largest[i] = c.log_likelihood[e];
      heir[i] = heir[c.parents[p]];
    }
  for (Index& component : component_of) component = heir[component];
}

/// Candidates whose next level has `target` components within 2 %, by bisection of the parent probability: more
/// parents, more components. The draws are nested, as the random numbers do not depend on the probability.
Candidates adapt_probability(const Mixture& level, Candidates at_or_below, std::size_t target,
                             const HemOptions& options, int number, const RunContext& context) {
  double low = options.parent_probability, high = 1;
  Candidates best = std::move(at_or_below);
  const auto error = [target](const Candidates& c) {
    return std::abs(static_cast<double>(c.next_size()) - static_cast<double>(target));
  };
  for (int step = 0; step < 30 && error(best) > 0.005 * static_cast<double>(target); ++step) {
    const double probability = 0.5 * (low + high);
    Candidates c = find_candidates(level, probability, {options.alpha}, number, context);
    (c.next_size() > target ? high : low) = probability;
    if (error(c) < error(best)) best = std::move(c);
  }
  return best;
}

/// Below this share of the automatic width the sheet is several Gaussians thick and falls apart in the triangulation
/// (hundreds of boundary loops on scans of closed shapes).
constexpr double sheet_threshold = 0.8;

/// The kernel width that the options ask for, in the units of the positions, and in words why.
struct Width {
  double sigma0;
  std::string choice;
};

double automatic_width(double spacing, double noise, InitialCovariance initial) {
  return initial == InitialCovariance::local ? local_width(spacing, noise) : isotropic_width(spacing, noise);
}

Width choose_width(const Scale& scale, const LengthScale& units, const HemOptions& options, const RunContext& context) {
  if (!options.sigma0.is_automatic())
    return {options.sigma0.resolve(units, "sigma0"), "given, " + options.sigma0.text()};
  const double automatic = automatic_sigma0(scale, options.initial);
  std::string choice = options.initial == InitialCovariance::local ? "sqrt((0.4 spacing)^2 + (1.6 noise)^2)"
                                                                   : "sqrt(spacing^2 + noise^2)";
  if (differs_by_point(scale)) choice += " at each point; the one told is that of the whole";
  if (scale.thin_walls) choice += ", thin walls: the noise of one of their sheets";
  if (options.detail == 1) return {automatic, choice};
  double factor = 1 / options.detail;
  choice += ", divided by detail " + std::to_string(options.detail);
  if (factor < sheet_threshold) {
    factor = sheet_threshold;
    choice += ", clamped at " + std::to_string(sheet_threshold) + " of it";
    context.warn("detail " + std::to_string(options.detail) +
                 " would tear the surface apart; the kernel width stays at " + std::to_string(sheet_threshold) +
                 " of the automatic one");
  }
  return {factor * automatic, choice};
}

/// Widths at the points, where the scale differs from that of the whole cloud and the options leave it automatic.
void make_local(Kernel& kernel, const Scale& scale, const HemOptions& options) {
  if (!differs_by_point(scale)) return;
  if (options.spacing.is_automatic()) kernel.spacing_at = scale.spacing_at;
  if (!options.sigma0.is_automatic()) return;
  const double factor = kernel.sigma0 / automatic_sigma0(scale, options.initial);
  kernel.sigma0_at.resize(scale.spacing_at.size());
  for (std::size_t i = 0; i < kernel.sigma0_at.size(); ++i)
    kernel.sigma0_at[i] = factor * automatic_width(scale.spacing_at[i], scale.noise_at[i], options.initial);
}

/// All levels; `index` is that of the points.
Mixture reduce(const PointCloud& cloud, const Neighbors& index, const Kernel& kernel, const HemOptions& options,
               const RunContext& context) {
  if (!(kernel.sigma0 > 0)) throw NoSurfaceError("the points coincide: their spacing is zero");
  Mixture level = initial_mixture(cloud, index, kernel, options, context);
  std::vector<Index> component_of;  // per point, if it is needed
  if (has_attributes(cloud)) {
    component_of.resize(cloud.size());
    std::iota(component_of.begin(), component_of.end(), Index{0});
  }
  if (options.on_level) options.on_level(0, level);
  const auto start = static_cast<double>(level.size());
  int number = 1;
  const auto advance = [&](Candidates& c) {
    responsibilities(c, level.size());
    if (!component_of.empty()) follow_points(component_of, c, level.size());
    level = next_level(level, c, context);
    context.progress("mixture", 1 - std::log(static_cast<double>(level.size())) / std::log(start + 1));
    if (options.on_level) options.on_level(number, level);
    ++number;
  };
  const std::size_t target = options.target_components;
  const auto worth_it = [&](const Candidates& c) {
    const double removed = 1 - static_cast<double>(c.next_size()) / static_cast<double>(level.size());
    return c.next_size() < level.size() && removed >= options.min_reduction;
  };
  const auto allowed = [&] { return options.max_levels == 0 || number <= options.max_levels; };
  while (allowed() && !(target > 0 && level.size() <= target)) {
    Candidates c = find_candidates(level, options.parent_probability, {options.alpha}, number, context);
    const bool last = target > 0 && c.next_size() <= target;
    if (last) c = adapt_probability(level, std::move(c), target, options, number, context);
    if (!last && !worth_it(c)) break;
    advance(c);
    if (last) break;
  }
  for (int flat = 0; flat < options.flat_levels && allowed() && !(target > 0 && level.size() <= target + target / 50);
       ++flat) {
    Candidates c = find_candidates(level, options.parent_probability, {options.flat_alpha, true}, number, context);
    if (!worth_it(c) || (target > 0 && c.next_size() < target)) break;
    advance(c);
  }
  if (!component_of.empty()) carry_attributes(cloud, component_of, level, context);
  return level;
}

}  // namespace

double automatic_sigma0(const Scale& scale, InitialCovariance initial) {
  return initial == InitialCovariance::local ? scale.sigma0_local : scale.sigma0;
}

void HemOptions::check() const {
  check_fields(*this);
  if (!sigma0.is_automatic() && detail != 1) throw OptionError("sigma0 and detail contradict each other");
}

Mixture build_mixture(const PointCloud& cloud, const HemOptions& options, const RunContext& context) {
  options.check();
  if (cloud.empty()) throw NoSurfaceError("no mixture of an empty cloud");
  const Neighbors index(cloud.positions);
  // An estimate of the scale only where the options need one.
  LengthScale units{.diagonal = bounding_box_diagonal(cloud.positions), .scene_to_local = 1 / cloud.frame.scale()};
  const bool needs_spacing = options.initial == InitialCovariance::local || options.balance;
  Scale scale;
  if (!options.sigma0.needs_no_estimate() || (needs_spacing && !options.spacing.needs_no_estimate())) {
    scale = estimate_scale(cloud, index, {}, context);
    units.spacing = scale.spacing;
  }
  Kernel kernel;
  kernel.spacing = options.spacing.resolve(units, "spacing", units.spacing);
  units.spacing = kernel.spacing;
  kernel.sigma0 = choose_width(scale, units, options, context).sigma0;
  make_local(kernel, scale, options);
  return reduce(cloud, index, kernel, options, context);
}

MixtureResult build_mixture(const PreparedCloud& cloud, const HemOptions& options, const RunContext& context) {
  options.check();
  const double unit = cloud.cloud.frame.scale();
  MixtureResult result;
  const Width width = choose_width(cloud.scale, cloud.lengths(), options, context);
  Kernel kernel{.sigma0 = width.sigma0,
                .spacing = options.spacing.resolve(cloud.lengths(), "spacing", cloud.scale.spacing)};
  make_local(kernel, cloud.scale, options);
  result.kernel = {.spacing = cloud.scale.spacing * unit,
                   .noise = cloud.scale.noise * unit,
                   .sigma0 = kernel.sigma0 * unit,
                   .choice = width.choice};
  HemOptions counted = options;
  counted.on_level = [&](int level, const Mixture& mixture) {
    result.statistics.levels.push_back(mixture.size());
    context.log(LogLevel::debug,
                "level " + std::to_string(level) + ": " + std::to_string(mixture.size()) + " Gaussians");
    if (options.on_level) options.on_level(level, mixture);
  };
  result.mixture = as_stored(reduce(cloud.cloud, *cloud.neighbors, kernel, counted, context));
  const Mixture& mixture = result.mixture;
  result.statistics.components = mixture.size();
  result.statistics.weight = std::accumulate(mixture.weights.begin(), mixture.weights.end(), 0.0);
  context.log(LogLevel::info, "mixture: " + std::to_string(mixture.size()) + " Gaussians after " +
                                  std::to_string(result.statistics.levels.size() - 1) + " levels");
  return result;
}

}  // namespace gpsrecon
