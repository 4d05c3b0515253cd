#include <gpsrecon/pipeline/choose_scale.h>

#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/hem/likelihood.h>
#include <gpsrecon/measure/held_out_error.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace gpsrecon::internal {
namespace {

/// Share of the budget that goes to the mixture; the fit spends the rest.
constexpr double mixture_share = 0.8;
/// A mixture is close enough to its target with this share of it.
constexpr double close_enough = 0.95;
constexpr int max_trials = 12;
/// No kernel is wider than 16 automatic ones: the time and memory of a level grow with the square of the width.
constexpr double min_detail = 1.0 / 16;
constexpr int max_half_octaves = 6;
constexpr int max_error_trials = 4;  // the automatic kernel and the bisection of six others

constexpr std::uint64_t error_stream = 0x6572726f72000000;
constexpr double error_share = 1.0 / 8;
constexpr std::uint64_t likelihood_stream = 0x6c696b65000000;
constexpr double likelihood_share = 1.0 / 5;
constexpr std::size_t min_held_out = 50;

/// Trials are not what is announced, logged or dumped.
RunContext silent(const RunContext& context) {
  RunContext quiet;
  quiet.threads = context.threads;
  quiet.seed = context.seed;
  quiet.cancel = context.cancel;
  return quiet;
}

ReconstructOptions trial_options(ReconstructOptions options, double detail) {
  options.hem.detail = detail;
  options.hem.on_level = nullptr;
  options.triangulate.on_snapshot = nullptr;
  options.self_intersections = false;
  return options;
}

/// Points drawn at random, and the others.
struct Split {
  std::vector<Index> held_out, rest;
};

Split split(std::size_t points, double share, std::uint64_t stream, std::uint64_t seed) {
  Split s;
  for (Index i = 0; i < points; ++i) (random_uniform(seed, stream, i) < share ? s.held_out : s.rest).push_back(i);
  return s;
}

struct Search {
  const PreparedCloud& cloud;
  const ReconstructOptions& options;
  const RunContext& context;
  ScaleSearchReport& found;

  RunContext quiet = silent(context);
};

// The budget.

/// Number of Gaussians at a level of detail, and with `triangulated` that of the vertices of their covariance mesh.
std::size_t try_detail(const Search& search, double detail, bool triangulated) {
  const ReconstructOptions options = trial_options(search.options, detail);
  const MixtureResult mixture = build_mixture(search.cloud, options.hem, search.quiet);
  ScaleTrial& trial = search.found.tried.emplace_back();
  trial.detail = detail;
  trial.sigma0 = mixture.kernel.sigma0;
  trial.components = mixture.mixture.size();
  search.found.chosen = search.found.tried.size() - 1;
  search.context.progress("scale", static_cast<double>(search.found.tried.size()) / (max_trials + 1));
  if (!triangulated) return trial.components;
  trial.vertices = triangulate(mixture.mixture, options.triangulate, search.quiet).mesh.vertices.size();
  return *trial.vertices;
}

/// ln detail at which the number of Gaussians reaches `target`, from the two trials closest to it.
double next_detail(const std::vector<ScaleTrial>& tried, double target) {
  const auto miss = [target](const ScaleTrial& t) {
    return std::abs(std::log(static_cast<double>(t.components) / target));
  };
  const auto off = [](const ScaleTrial& a, const ScaleTrial& b) {
    return std::log(static_cast<double>(a.components) / static_cast<double>(b.components));
  };
  const ScaleTrial *best = &tried.front(), *second = nullptr;
  for (const ScaleTrial& t : tried)
    if (miss(t) < miss(*best)) best = &t;
  for (const ScaleTrial& t : tried)
    if (t.detail != best->detail && (second == nullptr || miss(t) < miss(*second))) second = &t;
  // The number grows with the square of the detail where the kernel is wide, and slower elsewhere.
  double slope = second == nullptr ? 2 : off(*best, *second) / std::log(best->detail / second->detail);
  slope = std::clamp(slope, 0.5, 3.0);
  return best->detail * std::pow(target / static_cast<double>(best->components), 1 / slope);
}

/// Detail at which the mixture has about, and at most, `target` Gaussians. Throws OptionError if there is none.
double detail_for(const Search& search, double target) {
  const std::vector<ScaleTrial>& tried = search.found.tried;
  const auto largest_within = [&]() -> const ScaleTrial* {
    const ScaleTrial* best = nullptr;
    for (const ScaleTrial& t : tried)
      if (static_cast<double>(t.components) <= target && (best == nullptr || t.components > best->components))
        best = &t;
    return best;
  };
  for (int i = 0; i < max_trials; ++i) {
    const ScaleTrial* best = largest_within();
    if (best != nullptr && static_cast<double>(best->components) >= close_enough * target) break;
    const double detail = std::clamp(next_detail(tried, 0.5 * (1 + close_enough) * target), min_detail, 1.0);
    if (std::any_of(tried.begin(), tried.end(), [&](const ScaleTrial& t) { return t.detail == detail; })) break;
    try_detail(search, detail, false);
  }
  const ScaleTrial* best = largest_within();
  if (best == nullptr)
    throw OptionError("budget must be larger, not " + std::to_string(search.options.budget) +
                      ": the widest kernel leaves " + std::to_string(tried.back().components) + " Gaussians");
  return best->detail;
}

ReconstructOptions within_budget(const Search& search) {
  const std::size_t budget = search.options.budget;
  ReconstructOptions chosen = search.options;
  chosen.fit.max_vertices = budget;
  if (try_detail(search, 1, true) <= budget) return chosen;
  const bool refined = chosen.fit.steps > 0 && chosen.fit.refinements > 0;
  double target = (refined ? mixture_share : 1) * static_cast<double>(budget);
  // Filled holes and vertices that part may take more than the mixture leaves.
  for (std::size_t vertices = budget + 1; vertices > budget;
       target *= close_enough * static_cast<double>(budget) / static_cast<double>(vertices)) {
    chosen.hem.detail = detail_for(search, target);
    try {
      vertices = try_detail(search, chosen.hem.detail, true);
    } catch (const NoSurfaceError& error) {
      throw OptionError("budget must be larger, not " + std::to_string(budget) + ": " + error.what());
    }
  }
  return chosen;
}

// The error.

/// Vertices that the fit may lead to from a mixture: without a limit it would make up with them for a wide kernel, and
/// the coarsest mixture would not have the coarsest mesh.
std::size_t fit_limit(std::size_t components) {
  return static_cast<std::size_t>(static_cast<double>(components) / mixture_share);
}

/// Bound of the error of the chain on the points that are not held out; infinite if no surface comes out.
double try_error(const Search& search, const PreparedCloud& rest, const std::vector<Vec3>& held_out, double detail) {
  ReconstructOptions options = trial_options(search.options, detail);
  const double unit = rest.cloud.frame.scale();
  ScaleTrial& trial = search.found.tried.emplace_back();
  trial.detail = detail;
  const MixtureResult mixture = build_mixture(rest, options.hem, search.quiet);
  trial.sigma0 = mixture.kernel.sigma0;
  trial.components = mixture.mixture.size();
  if (detail < 1) options.fit.max_vertices = fit_limit(trial.components);
  search.context.progress("scale", static_cast<double>(search.found.tried.size()) / max_error_trials);
  Triangulation made;
  try {
    made = triangulate(mixture.mixture, options.triangulate, search.quiet);
  } catch (const NoSurfaceError&) {
    return std::numeric_limits<double>::infinity();
  }
  Fit fitted = fit({std::move(made.mesh), std::move(made.connectivity)}, rest, options.fit, search.quiet);
  trial.vertices = fitted.mesh.vertices.size();
  SubdivideOptions subdivision = options.subdivide;
  subdivision.attributes = false;
  const Mesh mesh =
      subdivide({std::move(fitted.mesh), std::move(fitted.connectivity)}, rest, subdivision, search.quiet);
  trial.error = held_out_error(mesh, held_out, search.quiet).bound() * unit;
  return *trial.error / rest.scene_diagonal();
}

ReconstructOptions within_error(const Search& search) {
  const PointCloud& cloud = search.cloud.cloud;
  ReconstructOptions chosen = search.options;
  const Split points = split(cloud.size(), error_share, error_stream, search.context.seed);
  if (points.held_out.size() < min_held_out) {
    search.context.warn("too few points to hold some out and measure an error; the kernel width stays automatic");
    return chosen;
  }
  const PreparedCloud rest = search.cloud.with_points(select(cloud, points.rest));
  std::vector<Vec3> held_out;
  for (const Index i : points.held_out) held_out.push_back(cloud.positions[i]);

  const double limit = search.found.wanted;
  const auto detail_of = [](int half_octaves) { return std::pow(2.0, -0.5 * half_octaves); };
  const double automatic = try_error(search, rest, held_out, 1);
  if (automatic > limit) {
    const std::string known =
        std::isinf(automatic) ? "no surface comes out without the points that are held out"
                              : "the error may be " + number(automatic) + " of the diagonal with the automatic kernel";
    search.context.warn(known + ": " + number(limit) + " cannot be promised; the kernel width stays automatic");
    return chosen;
  }
  int fine = 0, coarse = max_half_octaves + 1;
  while (coarse - fine > 1) {
    const int middle = (fine + coarse) / 2;
    if (try_error(search, rest, held_out, detail_of(middle)) > limit) {
      coarse = middle;
    } else {
      fine = middle;
      search.found.chosen = search.found.tried.size() - 1;
    }
  }
  chosen.hem.detail = detail_of(fine);
  if (fine > 0) chosen.fit.max_vertices = fit_limit(search.found.tried[search.found.chosen].components);
  return chosen;
}

}  // namespace

ScaleChoice choose_scale(const PreparedCloud& cloud, const ReconstructOptions& options, const RunContext& context) {
  ScaleChoice choice{options, std::nullopt, ""};
  if (options.budget == 0 && !options.max_error) return choice;
  const Search search{cloud, options, context, choice.search.emplace()};
  const bool by_budget = options.budget > 0;
  search.found.by = by_budget ? "budget" : "max_error";
  search.found.wanted = by_budget ? static_cast<double>(options.budget)
                                  : options.max_error->resolve(cloud.lengths(), "max-error") / cloud.diagonal;
  choice.options = by_budget ? within_budget(search) : within_error(search);
  choice.words = by_budget ? ", for at most " + std::to_string(options.budget) + " vertices"
                           : ", the widest with an error within " + options.max_error->text();
  for (const ScaleTrial& t : search.found.tried)
    context.log(LogLevel::info, "tried detail " + number(t.detail) + ": " + std::to_string(t.components) +
                                    " Gaussians" +
                                    (t.error ? ", error at most " + number(*t.error / cloud.scene_diagonal()) : ""));
  return choice;
}

std::optional<ScaleCheckReport> check_scale(const PreparedCloud& cloud, const ReconstructOptions& options,
                                            const RunContext& context) {
  const PointCloud& all = cloud.cloud;
  const Split points = split(all.size(), likelihood_share, likelihood_stream, context.seed);
  if (points.held_out.size() < min_held_out) {
    context.warn("too few points to hold some out and check the kernel width");
    return std::nullopt;
  }
  const PointCloud rest = select(all, points.rest), judges = select(all, points.held_out);
  const RunContext quiet = silent(context);
  const Scale scale = estimate_scale(rest, options.scale, quiet);
  HemOptions hem = options.hem;
  hem.on_level = nullptr;
  hem.detail = 1;
  const double unit = all.frame.scale();
  hem.spacing = Length::scene(scale.spacing * unit);
  LikelihoodOptions likelihood;
  likelihood.outlier_volume = std::pow(cloud.diagonal, 3);
  ScaleCheckReport check;
  check.held_out_points = judges.size();
  double weight = 0;
  for (std::size_t i = 0; i < judges.size(); ++i) weight += judges.weight(i);
  constexpr std::array factors{0.5, 1 / std::numbers::sqrt2, 1.0, std::numbers::sqrt2, 2.0};
  for (const double factor : factors) {
    const double sigma0 = factor * automatic_sigma0(scale, hem.initial) * unit;
    hem.sigma0 = Length::scene(sigma0);
    const Mixture mixture = build_mixture(rest, hem, quiet);
    const std::vector<double> values = log_likelihoods(mixture, judges.positions, likelihood, quiet);
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += judges.weight(i) * values[i];
    KernelLikelihood& tried = check.tried.emplace_back();
    tried.factor = factor;
    tried.sigma0 = sigma0;
    tried.components = mixture.size();
    // Densities per cubed diagonal, so that units do not matter.
    tried.mean_log_likelihood = sum / weight + 3 * std::log(cloud.diagonal);
    context.progress("scale", static_cast<double>(check.tried.size()) / factors.size());
    context.log(LogLevel::info,
                "kernel " + number(factor) + " of the automatic width: " + std::to_string(mixture.size()) +
                    " Gaussians, log-likelihood " + number(tried.mean_log_likelihood) + " per held-out point");
  }
  check.best = std::max_element(check.tried.begin(), check.tried.end(),
                                [](const KernelLikelihood& a, const KernelLikelihood& b) {
                                  return a.mean_log_likelihood < b.mean_log_likelihood;
                                })
                   ->factor;
  return check;
}

}  // namespace gpsrecon::internal
