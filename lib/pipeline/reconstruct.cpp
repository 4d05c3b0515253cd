#include <gpsrecon/pipeline/reconstruct.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/self_intersections.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/pipeline/choose_scale.h>

namespace gpsrecon {

using namespace internal;
namespace {

/// The context of a run, with a record of its own where the caller keeps none.
class Recorded {
 public:
  explicit Recorded(const RunContext& given) : context(given) {
    if (context.record == nullptr) context.record = &own_;
  }
  Recorded(const Recorded&) = delete;
  Recorded& operator=(const Recorded&) = delete;

  RunContext context;

 private:
  RunRecord own_;
};

void describe(const PreparedCloud& cloud, ErrorReport& report) {
  report.diagonal = cloud.scene_diagonal();
  report.input = InputReport{{}, cloud.rows, report.diagonal};
  report.dropped = {{"non_finite", cloud.non_finite}, {"duplicate", cloud.duplicates}, {"isolated", cloud.isolated}};
}

/// Without `reasons` loops keep those described before: their vertices may have moved, but are the same.
void describe(const CovMesh& mesh, const Connectivity& connectivity, ErrorReport& report,
              const std::vector<LoopReason>& reasons = {}) {
  CovMeshReport& described = report.covmesh ? *report.covmesh : report.covmesh.emplace();
  const std::vector<BoundaryLoop> before = std::move(described.boundary_loops);
  described.vertices = mesh.vertices.size();
  described.faces = mesh.faces.size();
  described.topology = topology(connectivity);
  std::vector<std::string> names;
  names.reserve(reasons.size());
  for (const LoopReason reason : reasons) names.emplace_back(name_of(reason));
  described.boundary_loops = measure_boundary_loops(mesh.vertices.means, connectivity, mesh.vertices.frame, names);
  for (BoundaryLoop& loop : described.boundary_loops)
    for (const BoundaryLoop& earlier : before)
      if (earlier.vertex == loop.vertex) loop.reason = earlier.reason;
}

ConnectedMesh triangulated(const Mixture& mixture, const ReconstructOptions& options, const RunContext& context,
                           ErrorReport& report) {
  context.begin("triangulate");
  Triangulation result = triangulate(mixture, options.triangulate, context);
  report.covmesh.emplace(CovMeshReport{result});
  describe(result.mesh, result.connectivity, report, result.loop_reasons);
  return {std::move(result.mesh), std::move(result.connectivity)};
}

ConnectedMesh fitted(ConnectedMesh mesh, const PreparedCloud& cloud, const ReconstructOptions& options,
                     const RunContext& context, ErrorReport& report) {
  context.begin("fit");
  Fit result = fit(std::move(mesh), cloud, options.fit, context);
  report.covmesh->flipped_components += result.flipped_components;
  if (options.fit.steps > 0) {
    report.fit = result;
    describe(result.mesh, result.connectivity, report);
  }
  return {std::move(result.mesh), std::move(result.connectivity)};
}

/// Refinement, and what is known of the result without points (null if there are none).
Reconstruction refined(ConnectedMesh connected, const PreparedCloud* cloud, const ReconstructOptions& options,
                       const RunContext& context, ErrorReport report) {
  context.begin("subdivide");
  CovMesh& mesh = connected.mesh;
  if (report.diagonal == 0) report.diagonal = bounding_box_diagonal(mesh.vertices.means) * mesh.vertices.frame.scale();
  SubdivideOptions subdivision = options.subdivide;
  if (!subdivision.tolerance && !subdivision.levels) subdivision.levels = automatic_level(connected);
  Reconstruction result;
  result.mesh = cloud != nullptr ? subdivide(connected, *cloud, subdivision, context)
                                 : subdivide(connected, subdivision, context);
  report.mesh = MeshReport{measure_mesh(result.mesh, context, options.self_intersections)};
  report.mesh->level = subdivision.levels;
  if (options.self_intersections)
    report.covmesh->self_intersecting_faces = self_intersecting_faces(mesh.vertices.means, mesh.faces, context).size();
  result.covmesh = std::move(mesh);
  report.command = "reconstruct";
  result.report = std::move(report);
  return result;
}

/// What cannot be done without points must not be passed over in silence.
void refuse_options_of_points(const ReconstructOptions& options) {
  if (options.budget > 0) throw OptionError("budget needs points");
  if (options.max_error) throw OptionError("max-error needs points");
  if (options.check_scale) throw OptionError("check-scale needs points");
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
  if (projection && max_error)
    throw OptionError("project and max-error contradict each other: projected points share their errors");
  if (budget > 0 && max_error) contradict("budget", "max-error");
  if (const char* chooses = budget > 0 ? "budget" : max_error ? "max-error" : nullptr) {
    if (hem.detail != 1) contradict(chooses, "detail");
    if (!hem.sigma0.is_automatic()) contradict(chooses, "sigma0");
    if (hem.target_components > 0) contradict(chooses, "target");
    if (fit.max_vertices > 0) contradict(chooses, "max-vertices");
  }
}

Reconstruction reconstruct(const PointCloud& world, const ReconstructOptions& given, const RunContext& caller) {
  given.check();
  const Recorded run(caller);
  const RunContext& context = run.context;
  ErrorReport report;
  context.begin("prepare");
  PreparedCloud cloud = prepare(world, given.scale, context);
  cloud.sensor = given.triangulate.sensor;
  describe(cloud, report);
  std::optional<PreparedCloud> projected;
  if (given.projection) {
    context.begin("project");
    // The kernel stays that of the scan: what noise is left in the particles they share over the support radius, and a
    // narrower kernel would take it for detail.
    projected = cloud.with_points(project_points(cloud, *given.projection, context));
  }
  const PreparedCloud& sheet = projected ? *projected : cloud;
  context.begin("scale");
  ScaleReport& scale = report.scale.emplace();
  if (given.check_scale) scale.check = check_scale(cloud, given, context);
  const ScaleChoice choice = choose_scale(sheet, given, context);
  const ReconstructOptions& options = choice.options;
  scale.search = choice.search;
  context.begin("mixture");
  MixtureResult mixture = build_mixture(sheet, options.hem, context);
  static_cast<KernelStatistics&>(scale) = std::move(mixture.kernel);
  scale.choice += choice.words;
  report.mixture = std::move(mixture.statistics);
  ConnectedMesh mesh = triangulated(mixture.mixture, options, context, report);
  mesh = fitted(std::move(mesh), cloud, options, context, report);
  Reconstruction result = refined(std::move(mesh), &cloud, options, context, std::move(report));
  context.begin("report");
  DistanceMeasures distances =
      measure_distances(SurfaceDistance(result.mesh, context), cloud.cloud, cloud.scene_diagonal(), context);
  distances.distance.index_of_max = cloud.source[distances.distance.index_of_max];
  result.report.points_to_surface = std::move(distances);
  result.report.compression = compression(result.covmesh, world.size());
  note_run(result.report, context);
  return result;
}

Reconstruction reconstruct(const Mixture& mixture, const ReconstructOptions& options, const RunContext& caller) {
  options.check();
  refuse_options_of_points(options);
  const Recorded run(caller);
  ErrorReport report;
  ConnectedMesh mesh = triangulated(mixture, options, run.context, report);
  Reconstruction result = refined(std::move(mesh), nullptr, options, run.context, std::move(report));
  note_run(result.report, run.context);
  return result;
}

Reconstruction reconstruct(const CovMesh& mesh, const ReconstructOptions& options, const RunContext& caller) {
  options.check();
  refuse_options_of_points(options);
  const Recorded run(caller);
  ErrorReport report;
  ConnectedMesh connected(mesh);
  describe(connected.mesh, connected.connectivity, report);
  Reconstruction result = refined(std::move(connected), nullptr, options, run.context, std::move(report));
  note_run(result.report, run.context);
  return result;
}

}  // namespace gpsrecon
