// Projects points and says on standard output, as JSON, what each phase cost and how good the particles are. Made for
// scripts/clop.py; options are pairs of a name and a value, see `Settings`.

#include <gpsrecon/clop/particles.h>
#include <gpsrecon/clop/project.h>
#include <gpsrecon/clop/repulsion.h>
#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/resource_usage.h>
#include <gpsrecon/hem/hem.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/pipeline/projection.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <gpsrecon/scan/gallery.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

using Json = nlohmann::ordered_json;

struct Settings {
  std::string points, method = "clop", truth, out, initial = "local";
  double h_rel = 0, h_factor = 1, sigma_factor = 1, subsample = 1;
  bool widen = false, balance = true, split = false, uniform = false, series = false;
  HemOptions hem{.flat_levels = 0};
  ParticleOptions particles;
  ProjectOptions project;
  RunContext context;
};

Settings parse(int argc, char** argv) {
  Settings s;
  s.project.convergence = 0;
  s.points = argv[1];
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    const double number = std::strtod(value.c_str(), nullptr);
    const int whole = static_cast<int>(number);
    if (name == "method")
      s.method = value;
    else if (name == "truth")
      s.truth = value;
    else if (name == "out")
      s.out = value;
    else if (name == "h_rel")
      s.h_rel = number;  // support radius, share of the diagonal
    else if (name == "h_factor")
      s.h_factor = number;  // times the automatic one
    else if (name == "sigma_factor")
      s.sigma_factor = number;  // kernel of the mixture, times projection_sigma0()
    else if (name == "subsample")
      s.subsample = number;  // share of the points, at random, that attract; particles still come from all
    else if (name == "widen")
      s.widen = whole != 0;  // automatic h for the spacing of the subsample
    else if (name == "initial")
      s.initial = value;
    else if (name == "ratio")
      s.particles.particles.ratio = number;
    else if (name == "count")
      s.particles.particles.count = static_cast<std::size_t>(number);
    else if (name == "uniform")
      s.uniform = whole != 0;
    else if (name == "balance")
      s.balance = whole != 0;
    else if (name == "alpha")
      s.hem.alpha = number;
    else if (name == "components")
      s.hem.target_components = static_cast<std::size_t>(number);
    else if (name == "levels")
      s.hem.max_levels = whole;
    else if (name == "flat_levels")
      s.hem.flat_levels = whole;
    else if (name == "iterations")
      s.project.iterations = whole;
    else if (name == "mu")
      s.project.repulsion = number;
    else if (name == "cutoff")
      s.project.repulsion_cutoff = number;
    else if (name == "interval")
      s.project.repulsion_interval = whole;
    else if (name == "tail")
      s.project.kernel = whole != 0 ? KernelCoefficients::tail : KernelCoefficients::published;
    else if (name == "split")
      s.split = whole != 0;  // time attraction and repulsion apart, by a run without the latter
    else if (name == "series")
      s.series = whole != 0;  // regularity and coherence of the repulsion per iteration
    else if (name == "threads")
      s.context.threads = whole;
    else
      throw OptionError("unknown setting " + name);
  }
  s.particles.selection = s.uniform ? ParticleSelection::uniform : ParticleSelection::random;
  s.hem.balance = s.project.balance = s.balance;
  s.hem.initial = s.initial == "local" ? InitialCovariance::local : InitialCovariance::isotropic;
  return s;
}

double quantile(std::vector<double>& values, double share) {
  return value_of_rank(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

/// Standard deviation of the distances to the nearest neighbour over their mean (Huang et al. 2009 take the deviation).
double irregularity(std::span<const Vec3> positions, const RunContext& context) {
  const Neighbors index(positions);
  std::vector<double> distance(positions.size());
  parallel_blocks(positions.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> near;
    for (std::size_t i = begin; i < end; ++i) {
      index.nearest(positions[i], 2, near);
      distance[i] = near.back().distance;
    }
  });
  double mean = 0, square = 0;
  for (const double d : distance) mean += d / static_cast<double>(distance.size());
  for (const double d : distance) square += (d - mean) * (d - mean) / static_cast<double>(distance.size());
  return std::sqrt(square) / mean;
}

/// Signed distances from the truth, positive outside, as shares of its diagonal. From a mesh: ⟨q - p, n⟩ with p the
/// nearest point and n the normal of its face.
std::vector<double> signed_errors(const PointCloud& world, const std::string& truth, const RunContext& context) {
  std::vector<double> error(world.size());
  if (truth.starts_with("shape:")) {
    const std::unique_ptr<const Shape> shape = make_shape(truth.substr(6));
    parallel_for(world.size(), context,
                 [&](std::size_t i) { error[i] = shape->distance(world.positions[i]) / shape->diagonal(); });
    return error;
  }
  const Mesh mesh = read_mesh(truth);
  const double diagonal = bounding_box_diagonal(mesh.positions);
  const SurfaceDistance surface(mesh, context);
  const std::vector<ClosestPoint> closest = surface.distances(world.positions, context);
  for (std::size_t i = 0; i < world.size(); ++i) {
    const auto face = mesh.faces[closest[i].face];
    const Vec3& a = mesh.positions[face[0]];
    const Vec3 normal = (mesh.positions[face[1]] - a).cross(mesh.positions[face[2]] - a);
    const bool outside = normal.dot(world.positions[i] - closest[i].point) >= 0;
    error[i] = (outside ? 1 : -1) * closest[i].distance / diagonal;
  }
  return error;
}

Json describe_errors(const std::vector<double>& error) {
  Json json;
  double sum = 0, absolute = 0, square = 0;
  const auto n = static_cast<double>(error.size());
  for (const double e : error) sum += e / n, absolute += std::abs(e) / n, square += e * e / n;
  json["signed_mean_percent"] = 100 * sum;
  json["mean_percent"] = 100 * absolute;
  json["rms_percent"] = 100 * std::sqrt(square);
  std::vector<double> magnitude = error;
  for (double& e : magnitude) e = std::abs(e);
  json["median_percent"] = 100 * quantile(magnitude, 0.5);
  json["p95_percent"] = 100 * quantile(magnitude, 0.95);
  constexpr int bins = 120;
  constexpr double limit = 0.006;
  std::vector<double> density(bins, 0.0);
  for (const double e : error) {
    const double at = (e / limit + 1) / 2 * bins;
    if (at >= 0 && at < bins) density[static_cast<std::size_t>(at)] += bins / (2 * 100 * limit * n);
  }
  json["density_limit_percent"] = 100 * limit;
  json["density_per_percent"] = density;
  return json;
}

int run(int argc, char** argv) {
  Settings s = parse(argc, argv);
  const RunContext& context = s.context;
  Json json;
  StageTimer timer;
  timer.start("prepare");
  const PreparedCloud prepared = prepare(read_points(s.points), {}, context);
  const PointCloud& points = prepared.cloud;
  const Scale& scale = prepared.scale;
  const double spacing = scale.spacing / std::sqrt(s.subsample);  // of what attracts
  const double automatic = automatic_support_radius(s.widen ? spacing : scale.spacing, scale.thickness);
  s.project.support_radius = s.h_rel > 0 ? s.h_rel * prepared.diagonal : s.h_factor * automatic;
  timer.start("particles");
  const PointCloud start = choose_particles(points, s.particles, context);

  // Not those that the particles come from, which would start where they are drawn to.
  RunContext other = context;
  ++other.seed;
  const PointCloud attracting =
      s.subsample < 1 ? choose_particles(points, {.particles = {.ratio = s.subsample}}, other) : PointCloud(points);

  std::vector<Vec3> before, now(start.size());
  Json series = Json::array();
  if (s.series)
    s.project.on_iteration = [&](const ProjectionProgress& p) {
      Json entry;
      entry["iteration"] = p.iteration;
      entry["irregularity"] = irregularity(p.positions, context);
      entry["largest_move"] = p.largest_move / s.project.support_radius;
      // ΔR (Preiner et al. 2014, section 8) of what the next iteration would have computed: p.repulsion may be older.
      update_repulsion(p.positions, s.project.support_radius, s.project.repulsion_cutoff, now, context);
      std::vector<double> change;
      for (std::size_t i = 0; i < before.size(); ++i)
        if (before[i].norm() > 0) change.push_back((now[i] - before[i]).norm() / before[i].norm());
      if (!change.empty())
        for (const double q : {0.1, 0.25, 0.5, 0.75, 0.9}) entry["coherence"].push_back(quantile(change, q));
      before = now;
      series.push_back(entry);
    };

  PointCloud result;
  std::size_t components = 0;
  const auto projected = [&](const auto& target) {
    if (s.split) {
      ProjectOptions still = s.project;
      still.repulsion = 0;
      still.on_iteration = nullptr;
      timer.start("attraction");
      project(start, target, still, context);
    }
    timer.start("project");
    result = project(start, target, s.project, context);
    timer.stop();
  };
  if (s.method == "none") {
    timer.stop();
    result = start;
  } else if (s.method == "clop") {
    s.hem.sigma0 = Length::scene(s.sigma_factor * projection_sigma0(scale, s.hem.initial) * attracting.frame.scale());
    s.hem.spacing = Length::scene(spacing * attracting.frame.scale());
    timer.start("mixture");
    const Mixture mixture = build_mixture(attracting, s.hem, context);
    components = mixture.size();
    projected(mixture);
  } else {
    projected(attracting);
  }

  json["points"] = points.size();
  json["particles"] = start.size();
  json["attracting"] = s.method == "clop" ? components : attracting.size();
  json["h_rel"] = s.project.support_radius / prepared.diagonal;
  json["h_spacings"] = s.project.support_radius / scale.spacing;
  json["spacing_rel"] = scale.spacing / prepared.diagonal;
  json["noise_rel"] = scale.noise / prepared.diagonal;
  for (const StageTime& t : timer.stages()) json["cpu_s"][t.name] = t.cpu_s;
  json["peak_memory_bytes"] = peak_memory_bytes();
  json["irregularity"] = irregularity(result.positions, context);
  if (s.series) json["series"] = series;
  const PointCloud world = in_frame(result, Frame{});
  if (!s.truth.empty()) json["errors"] = describe_errors(signed_errors(world, s.truth, context));
  if (!s.out.empty()) write_points(world, s.out);
  std::puts(json.dump().c_str());
  return 0;
}

}  // namespace
}  // namespace gpsrecon

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fputs("usage: projection_lab POINTS [NAME VALUE]...\n", stderr);
    return 2;
  }
  return gpsrecon::run(argc, argv);
} catch (const std::exception& error) {
  std::fprintf(stderr, "projection_lab: %s\n", error.what());
  return 1;
}
