#include "bind_options.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace gpsrecon::cli {
namespace {

void parse_holes(const std::string& text, TriangulateOptions& options) {
  const std::string fill = "fill:";
  if (text == "auto") {
    options.holes = HolePolicy::automatic;
  } else if (text == "keep") {
    options.holes = HolePolicy::keep;
  } else if (text == "all") {
    options.holes = HolePolicy::all;
  } else if (text.starts_with(fill)) {
    options.holes = HolePolicy::fill;
    options.fill_length_rel = parse_double(text.substr(fill.size()));
  } else {
    throw OptionError("expected auto, keep, fill:X or all, got '" + text + "'");
  }
}

/// A count, or as a percentage a ratio.
void parse_particles(const std::string& text, ParticleOptions& options) {
  options = {.selection = options.selection};
  if (text == "all") return;
  if (text.ends_with('%')) {
    options.ratio = parse_double(text.substr(0, text.size() - 1)) / 100;
  } else {
    options.count = parse_natural(text);
    if (options.count == 0) throw OptionError("expected all, a positive number N or X%, got '" + text + "'");
  }
}

/// One of several words, of which the text in force is that of `rule` or, if it is not given, of `usual` or the input.
template <class T>
void bind_rule(Arguments& arguments, const std::string& name, std::optional<T>& rule, const T* usual,
               const std::vector<std::pair<std::string, T>>& words, const std::string& meaning) {
  std::string names, otherwise = "that of the input";
  for (const auto& [word, meant] : words) {
    names += (names.empty() ? "" : "|") + word;
    if (usual != nullptr && meant == *usual) otherwise = word;
  }
  arguments.option(name, names, meaning, "", otherwise, [&rule, words, names](const std::string& text) {
    for (const auto& [word, meant] : words)
      if (word == text) return static_cast<void>(rule = meant);
    throw OptionError("expected one of " + names + ", got '" + text + "'");
  });
}

}  // namespace

void bind_scale(Arguments& arguments, ScaleOptions& options) {
  arguments.group("Points");
  arguments.option("--isolation", "X", options.isolation,
                   "drop points whose 8th neighbour is farther than X times the median such distance, 0 = keep all",
                   "> 1 or 0");
}

void bind_attributes(Arguments& arguments, AttributeOptions& options) {
  arguments.group("Points");
  arguments.option("--labels", "NAME,...",
                   "columns of whole numbers that are labels: decided by majority, never averaged; those named class, "
                   "label, segment and the like are anyway",
                   "", "none", [&options](const std::string& text) {
                     std::istringstream names(text);
                     options.labels.clear();
                     for (std::string name; std::getline(names, name, ',');) options.labels.push_back(name);
                   });
  arguments.option("--no-data", "X", "number that stands for a missing one in columns of scalars, besides NaN", "",
                   "none", [&options](const std::string& text) { options.no_data = parse_double(text); });
}

void bind_hem(Arguments& arguments, ReconstructOptions& options) {
  arguments.group("Mixture");
  arguments.option("--detail", "X", options.detail,
                   "divide the automatic kernel width by X: above 1 more detail, below 1 smoother", "(0, 100]");
  arguments.option(
      "--sigma0-rel", "X", options.sigma0_rel,
      "kernel width of a point as a share of the diagonal of the cloud, 0 = automatic, from sample spacing "
      "and noise",
      ">= 0");
  arguments.option("--alpha", "X", options.hem.alpha,
                   "how unlike Gaussians may be that merge: Kullback-Leibler divergence at most X^2/2", "(0, 10]");
  arguments.option("--hem-levels", "N", options.hem.max_levels,
                   "largest number of reduction levels, 0 = until a level hardly reduces", ">= 0");
  arguments.option("--flat-levels", "N", options.hem.flat_levels,
                   "levels after those, at most, that merge only within flat places", ">= 0");
  arguments.option("--flat-alpha", "X", options.hem.flat_alpha, "--alpha of those levels", "(0, 10]");
  arguments.option("--target", "N", options.hem.target_components,
                   "wanted number of Gaussians, hit within 2 % where the levels can reach it, 0 = as the levels end",
                   ">= 0");
  arguments.choice<InitialCovariance>(
      "--initial", options.hem.initial,
      {{"isotropic", InitialCovariance::isotropic}, {"local", InitialCovariance::local}},
      "Gaussian each point starts as: a ball, or the covariance of its neighbours scaled to the sample spacing");
  arguments.flag("--balance", options.hem.balance,
                 "weight points by the inverse of the local density, so that dense areas do not dominate");
}

void bind_scale_choice(Arguments& arguments, ReconstructOptions& options) {
  arguments.option("--budget", "N", options.budget,
                   "vertices of the covariance mesh, at most: the kernel is widened as far as it takes, and the fit "
                   "adds no more; 0 = no limit",
                   ">= 4 or 0");
  arguments.option("--max-error", "X", options.max_error_rel,
                   "widen the kernel as far as the error of the surface, measured on points that are held out, stays "
                   "within X times the diagonal; 0 = automatic",
                   ">= 0");
  arguments.flag("--check-scale", options.check_scale,
                 "compare kernel widths by the likelihood of points that are held out, for the report only");
}

void bind_projection(Arguments& arguments, ProjectionOptions& options) {
  arguments.group("Projection");
  arguments.choice<ProjectionMethod>(
      "--method", options.method,
      {{"clop", ProjectionMethod::clop}, {"wlop", ProjectionMethod::wlop}, {"lop", ProjectionMethod::lop}},
      "what draws the particles: a mixture of the points, the points weighted by the inverse of their density, or the "
      "points");
  arguments.option(
      "--particles", "all|N|X%",
      "particles: the points, a number of them, or a percentage; above 100 % there are new ones among them",
      "N > 0, X in (0, 10000]", "all",
      [&options](const std::string& text) { parse_particles(text, options.particles); });
  arguments.choice<ParticleSelection>("--selection", options.particles.selection,
                                      {{"random", ParticleSelection::random}, {"uniform", ParticleSelection::uniform}},
                                      "which points, where there are fewer particles: any, or evenly over the surface");
  arguments.option("--h-rel", "X", options.h_rel,
                   "support radius of the kernels as a share of the diagonal, 0 = automatic, from spacing and noise",
                   ">= 0");
  arguments.option("--iterations", "N", options.project.iterations, "iterations, at most", "[1, 1000]");
  arguments.option("--convergence", "X", options.project.convergence,
                   "stop when no particle moves farther than X support radii, 0 = never", ">= 0");
  arguments.option("--repulsion", "X", options.project.repulsion, "strength of the repulsion among particles",
                   "[0, 0.5)");
  arguments.option("--repulsion-cutoff", "X", options.project.repulsion_cutoff,
                   "particles farther apart than X support radii do not repel each other", "(0, 1]");
  arguments.option("--repulsion-interval", "N", options.project.repulsion_interval,
                   "recompute the repulsion in every N-th iteration, and in the last", ">= 1");
  arguments.choice<KernelCoefficients>(
      "--kernel", options.project.kernel,
      {{"published", KernelCoefficients::published}, {"tail", KernelCoefficients::tail}},
      "Gaussians that stand for the kernel with --method clop: close to it near the particle, or farther out");
  arguments.group("Mixture of --method clop");
  arguments.option("--sigma0-rel", "X", options.sigma0_rel,
                   "kernel width of a point as a share of the diagonal, 0 = automatic", ">= 0");
  arguments.option("--alpha", "X", options.hem.alpha,
                   "how unlike Gaussians may be that merge: Kullback-Leibler divergence at most X^2/2", "(0, 10]");
  arguments.option("--hem-levels", "N", options.hem.max_levels,
                   "largest number of reduction levels, 0 = until a level hardly reduces", ">= 0");
  arguments.flag("--no-balance", "do not weight points by the inverse of the local density",
                 [&options] { options.hem.balance = false; });
}

void bind_chain_projection(Arguments& arguments, ReconstructOptions& options) {
  arguments.group("Projection");
  const auto projection = [&options]() -> ProjectionOptions& {
    if (!options.projection) options.projection.emplace();
    return *options.projection;
  };
  arguments.option("--project", "clop|wlop|lop",
                   "make the mixture of particles projected to local medians of the points (gpsrecon project), not of "
                   "the points",
                   "", "none", [projection](const std::string& text) {
                     if (text == "clop")
                       projection().method = ProjectionMethod::clop;
                     else if (text == "wlop")
                       projection().method = ProjectionMethod::wlop;
                     else if (text == "lop")
                       projection().method = ProjectionMethod::lop;
                     else
                       throw OptionError("expected one of clop|wlop|lop, got '" + text + "'");
                   });
}

void bind_triangulate(Arguments& arguments, ReconstructOptions& options) {
  constexpr double degree = std::numbers::pi / 180;
  arguments.group("Triangulation");
  arguments.option("--min-overlap", "X", options.triangulate.min_overlap,
                   "smallest Bhattacharyya coefficient of two Gaussians that may share an edge", "(0, 1)");
  const auto degrees = [&options] { return options.triangulate.min_dihedral / degree; };
  arguments.option(
      "--min-dihedral", "DEGREES", "smallest dihedral angle between neighbouring triangles in degrees, 180 is flat",
      "[0, 180)", std::to_string(std::lround(degrees())),
      [&options](const std::string& text) { options.triangulate.min_dihedral = parse_double(text) * degree; },
      [degrees] { return OptionValue(degrees()); });
  arguments.option("--min-component", "X", options.triangulate.min_component_share,
                   "drop connected components with less than this share of the total weight", "[0, 1)");
  arguments.option("--min-weight", "X", options.triangulate.min_weight_share,
                   "leave out Gaussians with less than this share of the median weight of those that overlap them",
                   "[0, 1)");
  arguments.option("--max-pinhole", "N", options.triangulate.max_pinhole_edges,
                   "close boundary loops of at most N edges that the mixture itself bridges, 0 = none", ">= 0");
  arguments.option("--max-handle", "N", options.triangulate.max_handle_edges,
                   "remove handles that a loop of at most N edges cuts, where the mixture reaches across, 0 = none",
                   ">= 0");
  arguments.option(
      "--holes", "auto|keep|fill:X|all",
      "boundary loops to fill: those that Gaussians reach across, none, also those up to X times the diagonal, or all",
      "X >= 0", "auto", [&options](const std::string& text) { parse_holes(text, options.triangulate); });
  bind_sensor(arguments, options);
}

void bind_sensor(Arguments& arguments, ReconstructOptions& options) {
  arguments.option("--sensor", "X,Y,Z",
                   "where the sensor stood, in the coordinates of the input: open surfaces face it", "", "unknown",
                   [&options](const std::string& text) { options.sensor = parse_point(text); });
}

void bind_fit(Arguments& arguments, FitOptions& options) {
  arguments.group("Fit");
  arguments.option("--fit-steps", "N", options.steps,
                   "steps that move the surface through the points, at most, per round; 0 = no fit", "[0, 100]");
  arguments.option("--refinements", "N", options.refinements,
                   "rounds, at most, that split control edges where the points show more detail", "[0, 10]");
  arguments.option("--max-vertices", "N", options.max_vertices,
                   "vertices those rounds may lead to, at most, strongest detail first; 0 = no limit", ">= 0");
}

void GivenRules::bind(Arguments& arguments, const SurfaceRules& defaults) {
  bind(arguments, &defaults);
}

void GivenRules::bind(Arguments& arguments) {
  bind(arguments, nullptr);
}

void GivenRules::bind(Arguments& arguments, const SurfaceRules* defaults) {
  arguments.group("Surface");
  bind_rule<Scheme>(arguments, "--scheme", scheme_, defaults != nullptr ? &defaults->scheme : nullptr,
                    {{"loop", Scheme::loop}, {"catmull-clark", Scheme::catmull_clark}},
                    "refinement scheme: triangles to triangles, or polygons to quadrilaterals");
  bind_rule<CornerRule>(arguments, "--corners", corners_, defaults != nullptr ? &defaults->corners : nullptr,
                        {{"smooth", CornerRule::smooth}, {"sharp", CornerRule::sharp}},
                        "boundary vertices of a single face: rounded like the rest of the boundary, or kept");
  bind_rule<LoopWeights>(arguments, "--loop-weights", weights_, defaults != nullptr ? &defaults->weights : nullptr,
                         {{"loop", LoopWeights::loop}, {"warren", LoopWeights::warren}},
                         "weights of interior vertices: Loop's own, or Warren's simpler ones");
}

SurfaceRules GivenRules::over(const SurfaceRules& rules) const {
  return {.scheme = scheme_.value_or(rules.scheme),
          .weights = weights_.value_or(rules.weights),
          .corners = corners_.value_or(rules.corners)};
}

CovMesh GivenRules::over(CovMesh mesh, const std::string& path) const {
  mesh.rules = over(mesh.rules);
  if (mesh.rules.scheme == Scheme::loop)
    require_triangles(mesh, path, "Loop's scheme refines triangles, --scheme catmull-clark any polygons");
  return mesh;
}

void bind_subdivide(Arguments& arguments, ReconstructOptions& options) {
  arguments.group("Subdivision");
  arguments.option(
      "--levels", "auto|N",
      "refinement level of the mesh; auto = the smallest up to 3 whose edges are at most 1.5 sample spacings", "[0, 8]",
      options.levels < 0 ? "auto" : std::to_string(options.levels), [&options](const std::string& text) {
        options.levels = text == "auto" ? -1 : static_cast<int>(std::min<std::uint64_t>(parse_natural(text), 1000));
      });
  arguments.option(
      "--tolerance-rel", "X", options.tolerance_rel,
      "instead of levels: split faces until the mesh is within X times the diagonal of the limit surface, so "
      "that flat places stay coarse; 0 = levels",
      "> 0 or 0");
  arguments.flag(
      "--curvature", options.subdivide.curvature,
      "give the vertices curvatures, in 1/length: mean_curvature, gaussian_curvature, k1, k2, their directions "
      "and whether they are exact (ply)");
  arguments.flag("--covariances", options.subdivide.covariances, "give the vertices their covariances (ply)");
}

void bind_encoding(Arguments& arguments, PlyEncoding& encoding) {
  arguments.group("Output", false);
  arguments.flag("--ascii", "write PLY files as text instead of binary",
                 [&encoding] { encoding = PlyEncoding::ascii; });
}

}  // namespace gpsrecon::cli
