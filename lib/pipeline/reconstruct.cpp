#include <gpsrecon/core/attributes.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/principal_axes.h>
#include <gpsrecon/core/resource_usage.h>
#include <gpsrecon/core/self_intersections.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <gpsrecon/pipeline/choose_scale.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <gpsrecon/triangulate/orient.h>
#include <cmath>
#include <numeric>
#include <string>

namespace gpsrecon {
namespace {

/// Below this share of the automatic width the sheet is several Gaussians thick and falls apart in the triangulation
/// (hundreds of boundary loops on scans of closed shapes).
constexpr double sheet_threshold = 0.8;

void refuse_degenerate(const PointCloud& cloud) {
  const std::size_t n = cloud.size();
  if (n < 3) throw NoSurfaceError("no surface through " + std::to_string(n) + " distinct point" + (n == 1 ? "" : "s"));
  if (on_a_line(cloud.positions)) throw NoSurfaceError("all points lie on a line: no surface");
}

double kernel_width(const PreparedCloud& cloud, const ReconstructOptions& options, const RunContext& context,
                    ErrorReport& report, std::string& choice) {
  const Scale& scale = cloud.scale;
  if (!options.hem.sigma0.is_automatic()) {
    choice = "given, " + options.hem.sigma0.text();
    return options.hem.sigma0.resolve(cloud.lengths(), "sigma0");
  }
  const bool local = options.hem.initial == InitialCovariance::local;
  const double automatic = automatic_sigma0(scale, options.hem.initial);
  choice = local ? "sqrt((0.4 spacing)^2 + (1.6 noise)^2)" : "sqrt(spacing^2 + noise^2)";
  if (scale.thin_walls) choice += ", thin walls: the noise of one of their sheets";
  if (options.detail == 1) return automatic;
  double factor = 1 / options.detail;
  choice += ", divided by detail " + std::to_string(options.detail);
  if (factor < sheet_threshold) {
    factor = sheet_threshold;
    choice += ", clamped at " + std::to_string(sheet_threshold) + " of it";
    const std::string warning = "detail " + std::to_string(options.detail) +
                                " would tear the surface apart; the kernel width stays at " +
                                std::to_string(sheet_threshold) + " of the automatic one";
    context.warn(warning);
    report.warnings.push_back(warning);
  }
  return factor * automatic;
}

void describe_input(const PreparedCloud& cloud, std::size_t rows, ErrorReport& report) {
  report.diagonal = cloud.diagonal * cloud.clean.cloud.frame.scale();
  report.input.emplace();
  report.input->points = rows;
  report.input->diagonal = report.diagonal;
  report.dropped = {
      {"non_finite", cloud.clean.non_finite}, {"duplicate", cloud.clean.duplicates}, {"isolated", cloud.isolated}};
}

/// Without `reasons` loops keep those described before: their vertices may have moved, but are the same.
void describe_covmesh(const CovMesh& mesh, ErrorReport& report, const std::vector<std::string>& reasons = {}) {
  CovMeshReport& described = report.covmesh ? *report.covmesh : report.covmesh.emplace();
  const std::vector<BoundaryLoop> before = std::move(described.boundary_loops);
  described.vertices = mesh.vertices.size();
  described.faces = mesh.faces.size();
  described.topology = topology(mesh.faces, mesh.vertices.size());
  described.boundary_loops = measure_boundary_loops(mesh.vertices.means, mesh.faces, mesh.vertices.frame, reasons);
  for (BoundaryLoop& loop : described.boundary_loops)
    for (const BoundaryLoop& earlier : before)
      if (earlier.vertex == loop.vertex) loop.reason = earlier.reason;
}

/// Subdivision, and what is known of the result without points (null if there are none).
Reconstruction finish(CovMesh mesh, const PreparedCloud* cloud, const ReconstructOptions& options,
                      const RunContext& context, ErrorReport report, StageTimer& timer) {
  Reconstruction result;
  timer.start("subdivide");
  result.mesh = cloud != nullptr ? subdivide_stage(mesh, *cloud, options, context, report)
                                 : subdivide_stage(mesh, options, context, report);
  if (options.self_intersections)
    report.covmesh->self_intersecting_faces = self_intersecting_faces(mesh.vertices.means, mesh.faces, context).size();
  result.covmesh = std::move(mesh);
  result.report = std::move(report);
  return result;
}

void close_books(Reconstruction& result, const RunContext& context, StageTimer& timer) {
  timer.stop();
  ErrorReport& report = result.report;
  report.command = "reconstruct";
  report.seed = context.seed;
  report.versions = library_versions();
  report.run.threads = context.thread_count();
  report.run.stages = timer.stages();
  const StageTime total = timer.total();
  report.run.wall_s = total.wall_s;
  report.run.cpu_s = total.cpu_s;
  report.run.peak_memory_bytes = peak_memory_bytes();
}

/// Per point a vector to the outer side: the way to the sensor that was given, else to the point's own, else its
/// normal. Empty if nothing tells.
std::vector<Vec3> outward_directions(const PointCloud& cloud, const std::optional<Vec3>& sensor) {
  if (!sensor && cloud.sensors.empty()) return cloud.normals;
  const Vec3 at = sensor ? cloud.frame.to_local(*sensor) : Vec3::Zero();
  std::vector<Vec3> directions(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) directions[i] = (sensor ? at : cloud.sensors[i]) - cloud.positions[i];
  return directions;
}

/// What cannot be done without points must not be passed over in silence.
void refuse_scale_options(const ReconstructOptions& options) {
  if (options.budget > 0) throw OptionError("budget needs points");
  if (options.max_error) throw OptionError("max-error needs points");
  if (options.check_scale) throw OptionError("check-scale needs points");
}

double covmesh_diagonal(const CovMesh& mesh) {
  return bounding_box_diagonal(mesh.vertices.means) * mesh.vertices.frame.scale();
}

}  // namespace

void ReconstructOptions::check() const {
  scale.check();
  hem.check();
  triangulate.check();
  fit.check();
  subdivide.check();
  if (projection) projection->check();
  check_fields(*this);
  const auto contradict = [](const char* one, const char* other) {
    throw OptionError(std::string(one) + " and " + other + " contradict each other");
  };
  if (!hem.sigma0.is_automatic() && detail != 1) contradict("sigma0", "detail");
  if (projection && max_error)
    throw OptionError("project and max-error contradict each other: projected points share their errors");
  if (budget > 0 && max_error) contradict("budget", "max-error");
  if (const char* chooses = budget > 0 ? "budget" : max_error ? "max-error" : nullptr) {
    if (detail != 1) contradict(chooses, "detail");
    if (!hem.sigma0.is_automatic()) contradict(chooses, "sigma0");
    if (hem.target_components > 0) contradict(chooses, "target");
    if (fit.max_vertices > 0) contradict(chooses, "max-vertices");
  }
}

LengthScale PreparedCloud::lengths() const {
  return {.diagonal = diagonal, .spacing = scale.spacing, .scene_to_local = 1 / clean.cloud.frame.scale()};
}

PreparedCloud prepare(const PointCloud& world, const ScaleOptions& options, const RunContext& context) {
  PreparedCloud prepared;
  prepared.clean = clean(world, context);
  refuse_degenerate(prepared.clean.cloud);
  prepared.scale = estimate_scale(prepared.clean.cloud, options, context);
  const std::vector<Index>& isolated = prepared.scale.isolated;
  prepared.isolated = isolated.size();
  if (!isolated.empty()) {
    std::vector<Index> kept;
    kept.reserve(prepared.clean.cloud.size() - isolated.size());
    for (Index i = 0, next = 0; i < prepared.clean.cloud.size(); ++i) {
      if (next < isolated.size() && isolated[next] == i)
        ++next;
      else
        kept.push_back(i);
    }
    prepared.clean.cloud = select(prepared.clean.cloud, kept);
    for (Index& k : kept) k = prepared.clean.source[k];
    prepared.clean.source = std::move(kept);
    refuse_degenerate(prepared.clean.cloud);
  }
  prepared.diagonal = bounding_box_diagonal(prepared.clean.cloud.positions);
  context.log(LogLevel::info, "points: " + std::to_string(world.size()) + " read, " +
                                  std::to_string(prepared.clean.cloud.size()) + " distinct ones used; dropped " +
                                  std::to_string(prepared.clean.non_finite) + " not finite, " +
                                  std::to_string(prepared.isolated) + " isolated; merged " +
                                  std::to_string(prepared.clean.duplicates) + " duplicates");
  return prepared;
}

Mixture mixture_stage(const PreparedCloud& cloud, const ReconstructOptions& options, const RunContext& context,
                      ErrorReport& report) {
  const double unit = cloud.clean.cloud.frame.scale();
  ScaleReport& scale = report.scale ? *report.scale : report.scale.emplace();
  HemOptions hem = options.hem;
  const double spacing = options.hem.spacing.resolve(cloud.lengths(), "spacing", cloud.scale.spacing);
  const double sigma0 = kernel_width(cloud, options, context, report, scale.choice);
  hem.spacing = Length::scene(spacing * unit);
  hem.sigma0 = Length::scene(sigma0 * unit);
  if (options.budget > 0) scale.choice += ", for at most " + std::to_string(options.budget) + " vertices";
  if (options.max_error) scale.choice += ", the widest with an error within " + options.max_error->text();
  scale.spacing = cloud.scale.spacing * unit;
  scale.noise = cloud.scale.noise * unit;
  scale.sigma0 = sigma0 * unit;

  MixtureReport& described = report.mixture.emplace();
  hem.on_level = [&](int level, const Mixture& mixture) {
    described.levels.push_back(mixture.size());
    context.log(LogLevel::debug,
                "level " + std::to_string(level) + ": " + std::to_string(mixture.size()) + " Gaussians");
    if (options.hem.on_level) options.hem.on_level(level, mixture);
  };
  Mixture mixture = build_mixture(cloud.clean.cloud, hem, context);
  mixture = as_stored(mixture);  // so that the stages run one by one, through files, give the chain's bits
  described.components = mixture.size();
  described.weight = std::accumulate(mixture.weights.begin(), mixture.weights.end(), 0.0);
  context.log(LogLevel::info, "mixture: " + std::to_string(mixture.size()) + " Gaussians after " +
                                  std::to_string(described.levels.size() - 1) + " levels");
  return mixture;
}

CovMesh triangulate_stage(const Mixture& mixture, const ReconstructOptions& options, const RunContext& context,
                          ErrorReport& report) {
  Triangulation result = triangulate(mixture, options.triangulate, context);
  result.mesh.vertices = as_stored(result.mesh.vertices);
  CovMeshReport& described = report.covmesh.emplace();
  described.light_components = result.light_components;
  described.light_weight = result.light_weight;
  described.leftover_components = result.leftover_components;
  described.leftover_weight = result.leftover_weight;
  described.dropped_specks = result.dropped_specks;
  described.dropped_speck_weight = result.dropped_speck_weight;
  described.split_vertices = result.split_vertices;
  described.flipped_edges = result.flipped_edges;
  described.closed_pinholes = result.closed_pinholes;
  described.removed_handles = result.removed_handles;
  described.untangled = result.untangled;
  described.filled_holes = result.filled_holes;
  described.filled_rims = result.filled_rims;
  described.filled_vertices = result.filled_vertices;
  described.flipped_components = result.flipped_components;
  std::vector<std::string> reasons;
  for (const LoopReason reason : result.loop_reasons) reasons.emplace_back(name_of(reason));
  describe_covmesh(result.mesh, report, reasons);
  context.log(LogLevel::info, "triangulate: " + std::to_string(described.faces) + " faces over " +
                                  std::to_string(described.vertices) + " Gaussians, " +
                                  std::to_string(described.boundary_loops.size()) + " boundary loops");
  return std::move(result.mesh);
}

CovMesh fit_stage(CovMesh mesh, const PreparedCloud& cloud, const ReconstructOptions& options,
                  const RunContext& context, ErrorReport& report) {
  std::optional<PointCloud> moved;
  if (!(cloud.clean.cloud.frame == mesh.vertices.frame)) moved = in_frame(cloud.clean.cloud, mesh.vertices.frame);
  const PointCloud& points = moved ? *moved : cloud.clean.cloud;
  if (const std::vector<Vec3> directions = outward_directions(points, options.triangulate.sensor);
      !directions.empty()) {
    const std::size_t turned = orient_by_vote(mesh.vertices, mesh.faces, points, directions, context);
    if (report.covmesh) report.covmesh->flipped_components += turned;
  }
  if (options.fit.steps == 0) return mesh;
  const std::vector<Vec3> before = mesh.vertices.means;
  Fit result = fit(std::move(mesh), points, options.fit, context);
  mesh = std::move(result.mesh);
  mesh.vertices = as_stored(mesh.vertices);
  const double unit = mesh.vertices.frame.scale();
  FitReport& described = report.fit.emplace();
  described.steps = result.steps;
  described.refinements = result.refinements;
  described.added_vertices = result.added_vertices;
  described.restrained_faces = result.restrained_faces;
  described.held_out_points = result.held_out_points;
  described.held_out_before = result.held_out_before * unit;
  described.held_out_after = result.held_out_after * unit;
  for (std::size_t v = 0; v < before.size(); ++v) {
    const double shift = unit * (mesh.vertices.means[v] - before[v]).norm();
    described.mean_shift += shift / static_cast<double>(before.size());
    described.max_shift = std::max(described.max_shift, shift);
  }
  describe_covmesh(mesh, report);
  context.log(LogLevel::info, "fit: " + std::to_string(described.steps) + " steps, " +
                                  std::to_string(described.added_vertices) + " vertices added in " +
                                  std::to_string(described.refinements) + " refinements");
  return mesh;
}

Mesh subdivide_stage(const CovMesh& mesh, const ReconstructOptions& options, const RunContext& context,
                     ErrorReport& report) {
  if (report.diagonal == 0) report.diagonal = covmesh_diagonal(mesh);
  SubdivideOptions subdivision = options.subdivide;
  const bool adaptive = subdivision.tolerance.has_value();
  if (adaptive)  // a share is of the diagonal of the points, if there are any
    subdivision.tolerance = Length::scene(subdivision.tolerance->resolve(
        {.diagonal = report.diagonal, .spacing = mesh.vertices.spacing * mesh.vertices.frame.scale()}, "tolerance"));
  else if (!subdivision.levels)
    subdivision.levels = automatic_level(mesh);
  Mesh refined = subdivide(mesh, subdivision, context);
  report.mesh = MeshReport{measure_mesh(refined, context, options.self_intersections)};
  if (!adaptive) report.mesh->level = subdivision.levels;
  context.log(LogLevel::info,
              "subdivide: " + std::to_string(refined.faces.size()) + " faces " +
                  (adaptive ? "within the tolerance" : "at level " + std::to_string(*subdivision.levels)));
  return refined;
}

Mesh subdivide_stage(const CovMesh& mesh, const PreparedCloud& cloud, const ReconstructOptions& options,
                     const RunContext& context, ErrorReport& report) {
  const PointCloud& points = cloud.clean.cloud;
  ReconstructOptions local = options;
  local.subdivide.attributes = !has_attributes(points);
  Mesh refined = subdivide_stage(mesh, local, context, report);
  if (points.frame == refined.frame)
    attributes_from_points(refined, points, context);
  else
    attributes_from_points(refined, in_frame(points, refined.frame), context);
  return refined;
}

Reconstruction reconstruct(const PointCloud& world, const ReconstructOptions& given, const RunContext& context) {
  given.check();
  StageTimer timer;
  ErrorReport report;
  timer.start("prepare");
  const PreparedCloud cloud = prepare(world, given.scale, context);
  describe_input(cloud, world.size(), report);
  std::optional<PreparedCloud> projected;
  if (given.projection) {
    timer.start("project");
    projected = cloud;
    projected->clean.cloud = project_points(cloud.clean.cloud, cloud.scale, cloud.diagonal, *given.projection, context);
    // The kernel stays that of the scan: what noise is left in the particles they share over the support radius, and a
    // narrower kernel would take it for detail.
  }
  const PreparedCloud& sheet = projected ? *projected : cloud;
  timer.start("scale");
  if (given.check_scale) check_scale(cloud, given, context, report);
  const ReconstructOptions options = choose_scale(sheet, given, context, report);
  timer.start("mixture");
  const Mixture mixture = mixture_stage(sheet, options, context, report);
  timer.start("triangulate");
  CovMesh mesh = triangulate_stage(mixture, options, context, report);
  timer.start("fit");
  mesh = fit_stage(std::move(mesh), cloud, options, context, report);
  Reconstruction result = finish(std::move(mesh), &cloud, options, context, std::move(report), timer);
  timer.start("report");
  result.report.points_to_surface =
      measure_distances(SurfaceDistance(result.mesh, context), cloud.clean.cloud, result.report.diagonal, context);
  result.report.compression = compression(result.covmesh, world.size());
  close_books(result, context, timer);
  return result;
}

Reconstruction reconstruct(const Mixture& mixture, const ReconstructOptions& options, const RunContext& context) {
  options.check();
  refuse_scale_options(options);
  StageTimer timer;
  ErrorReport report;
  timer.start("triangulate");
  CovMesh mesh = triangulate_stage(mixture, options, context, report);
  Reconstruction result = finish(std::move(mesh), nullptr, options, context, std::move(report), timer);
  close_books(result, context, timer);
  return result;
}

Reconstruction reconstruct(const CovMesh& mesh, const ReconstructOptions& options, const RunContext& context) {
  options.check();
  refuse_scale_options(options);
  StageTimer timer;
  ErrorReport report;
  describe_covmesh(mesh, report);
  Reconstruction result = finish(mesh, nullptr, options, context, std::move(report), timer);
  close_books(result, context, timer);
  return result;
}

}  // namespace gpsrecon
