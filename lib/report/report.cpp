#include <gpsrecon/report/report.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>

namespace gpsrecon {

using namespace internal;
namespace {

using Json = nlohmann::ordered_json;

Json relative(double length, double diagonal) {
  return diagonal > 0 ? Json(length / diagonal) : Json(nullptr);
}

/// A length in scene units and as a share of the diagonal.
Json length_json(double length, double diagonal) {
  return {{"scene", length}, {"rel", relative(length, diagonal)}};
}

Json vector_json(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

template <class T>
Json null_or(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_object(const FileReport& r) {
  return {{"file", r.file}, {"format", r.format}, {"hash", r.hash.empty() ? Json(nullptr) : Json(r.hash)}};
}

Json to_object(const InputReport& r) {
  Json json = to_object(r.file);
  json["points"] = r.points;
  json["diagonal"] = r.diagonal;
  return json;
}

Json to_object(const ScaleSearchReport& r, double diagonal) {
  Json tried = Json::array();
  for (const ScaleTrial& t : r.tried)
    tried.push_back({{"detail", t.detail},
                     {"sigma0", length_json(t.sigma0, diagonal)},
                     {"components", t.components},
                     {"vertices", null_or(t.vertices)},
                     {"error", t.error ? length_json(*t.error, diagonal) : Json(nullptr)}});
  return {{"by", r.by}, {"wanted", r.wanted}, {"chosen", r.chosen}, {"tried", std::move(tried)}};
}

Json to_object(const ScaleCheckReport& r, double diagonal) {
  Json tried = Json::array();
  for (const KernelLikelihood& t : r.tried)
    tried.push_back({{"factor", t.factor},
                     {"sigma0", length_json(t.sigma0, diagonal)},
                     {"components", t.components},
                     {"mean_log_likelihood", t.mean_log_likelihood}});
  return {{"held_out_points", r.held_out_points}, {"best", r.best}, {"tried", std::move(tried)}};
}

Json to_object(const ScaleReport& r, double diagonal) {
  return {{"spacing", length_json(r.spacing, diagonal)},
          {"noise", length_json(r.noise, diagonal)},
          {"sigma0", length_json(r.sigma0, diagonal)},
          {"choice", r.choice},
          {"search", r.search ? to_object(*r.search, diagonal) : Json(nullptr)},
          {"check", r.check ? to_object(*r.check, diagonal) : Json(nullptr)}};
}

/// The numbers of a stage under their own names.
template <class Statistics>
Json counts_json(const Statistics& statistics) {
  Json json = Json::object();
  statistics.each([&](const char* name, const auto& value) { json[name] = value; });
  return json;
}

Json to_object(const Topology& t) {
  return {{"vertices", t.vertices},
          {"unused_vertices", t.unused_vertices},
          {"edges", t.edges},
          {"faces", t.faces},
          {"components", t.components},
          {"euler", t.euler},
          {"closed", is_closed(t)},
          {"genus", null_or(genus(t))},
          {"boundary_loops", t.boundary_loops},
          {"boundary_edges", t.boundary_edges},
          {"nonmanifold_edges", t.nonmanifold_edges},
          {"nonmanifold_vertices", t.nonmanifold_vertices},
          {"inconsistent_edges", t.inconsistent_edges}};
}

Json to_object(const BoundaryLoop& r, double diagonal) {
  return {{"edges", r.edges},
          {"length", length_json(r.length, diagonal)},
          {"center", vector_json(r.center)},
          {"reason", r.reason}};
}

Json to_object(const CovMeshReport& r, double diagonal) {
  Json json = {{"vertices", r.vertices}, {"faces", r.faces}, {"topology", to_object(r.topology)}};
  json.update(counts_json<TriangulationStatistics>(r));
  json["self_intersecting_faces"] = null_or(r.self_intersecting_faces);
  Json& loops = json["boundary_loops"] = Json::array();
  for (const BoundaryLoop& loop : r.boundary_loops) loops.push_back(to_object(loop, diagonal));
  return json;
}

Json to_object(const FitStatistics& r, double diagonal) {
  Json json = Json::object();
  r.each([&](const char* name, const auto& value) { json[name] = value; },
         [&](const char* name, double length) { json[name] = length_json(length, diagonal); });
  return json;
}

Json to_object(const MeshReport& r) {
  return {{"file", r.file ? to_object(*r.file) : Json(nullptr)},
          {"level", null_or(r.level)},
          {"vertices", r.vertices},
          {"faces", r.faces},
          {"topology", to_object(r.topology)},
          {"area", r.area},
          {"volume", null_or(r.volume)},
          {"self_intersecting_faces", null_or(r.self_intersecting_faces)}};
}

Json values_json(const Statistics& s) {
  return {{"mean", s.mean}, {"rms", s.rms}, {"median", s.median}, {"p95", s.p95}, {"p99", s.p99}, {"max", s.max}};
}

Json to_object(const DistanceMeasures& r, double diagonal) {
  const Statistics& s = r.distance;
  return {{"count", s.count},
          {"weight", s.weight},
          {"scene", values_json(s)},
          {"rel", diagonal > 0 ? values_json(scaled(s, 1 / diagonal)) : Json(nullptr)},
          {"index_of_max", s.index_of_max},
          {"max_at", vector_json(r.max_at)},
          {"histogram",
           r.histogram ? Json{{"edges_rel", r.histogram->edges}, {"counts", r.histogram->counts}} : Json(nullptr)}};
}

Json to_object(const NormalMeasures& r) {
  return {{"count", r.count}, {"mean_deg", r.mean}, {"p95_deg", r.p95}, {"flipped", r.flipped}};
}

Json to_object(const DirectionMeasures& r, double diagonal) {
  return {{"distance", to_object(r.distance, diagonal)},
          {"normals", to_object(r.normals)},
          {"signed_mean", r.signed_mean ? length_json(*r.signed_mean, diagonal) : Json(nullptr)},
          {"within", r.within},
          {"far", {{"share", r.far}, {"area", null_or(r.far_area)}}}};
}

Json to_object(const Thresholds& r) {
  return {{"fscore_rel", r.fscore_rel}, {"far_rel", r.far_rel}};
}

Json to_object(const ReferenceReport& r) {
  return {{"file", r.file ? to_object(*r.file) : Json(nullptr)},
          {"diagonal", r.diagonal},
          {"samples", r.samples},
          {"thresholds", to_object(r.thresholds)},
          {"f_score", r.f_score()},
          {"mesh_to_reference", to_object(r.mesh_to_reference, r.diagonal)},
          {"reference_to_mesh", to_object(r.reference_to_mesh, r.diagonal)}};
}

Json to_object(const Alignment& r, double diagonal) {
  Json rotation = Json::array();
  for (Eigen::Index row = 0; row < 3; ++row) rotation.push_back(vector_json(r.rotation.row(row).transpose()));
  return {{"rotation", std::move(rotation)},
          {"translation", vector_json(r.translation)},
          {"iterations", r.iterations},
          {"converged", r.converged},
          {"rms_before", length_json(r.rms_before, diagonal)},
          {"rms_after", length_json(r.rms_after, diagonal)}};
}

Json to_object(const Compression& r) {
  return {{"numbers_read", r.numbers_read}, {"numbers_stored", r.numbers_stored}, {"ratio", r.ratio}};
}

Json to_object(const RunReport& r) {
  Json stages = Json::array();
  for (const StageTime& stage : r.stages)
    stages.push_back({{"name", stage.name}, {"wall_s", stage.wall_s}, {"cpu_s", stage.cpu_s}});
  return {{"threads", r.threads},
          {"wall_s", r.wall_s},
          {"cpu_s", r.cpu_s},
          {"peak_memory_bytes", r.peak_memory_bytes},
          {"stages", std::move(stages)}};
}

template <class T, class... Context>
Json optional_json(const std::optional<T>& part, const Context&... context) {
  return part ? to_object(*part, context...) : Json(nullptr);
}

Json to_object(const ErrorReport& r) {
  const double diagonal = r.diagonal;
  Json dropped = Json::array(), options = Json::object(), versions = Json::object();
  for (const DroppedPoints& d : r.dropped) dropped.push_back({{"reason", d.reason}, {"points", d.points}});
  for (const auto& [name, value] : r.options) std::visit([&, &key = name](const auto& v) { options[key] = v; }, value);
  for (const auto& [name, version] : r.versions) versions[name] = version;
  return {{"schema", "gpsrecon.report/1"},
          {"version", r.version},
          {"command", r.command},
          {"diagonal", diagonal},
          {"input", optional_json(r.input)},
          {"dropped", std::move(dropped)},
          {"scale", optional_json(r.scale, diagonal)},
          {"mixture", r.mixture ? counts_json(*r.mixture) : Json(nullptr)},
          {"covmesh", optional_json(r.covmesh, diagonal)},
          {"fit", optional_json(r.fit, diagonal)},
          {"mesh", optional_json(r.mesh)},
          {"points_to_surface", optional_json(r.points_to_surface, diagonal)},
          {"surface_to_points", optional_json(r.surface_to_points, diagonal)},
          {"thresholds", optional_json(r.thresholds)},
          {"reference", optional_json(r.reference)},
          {"alignment", optional_json(r.alignment, diagonal)},
          {"compression", optional_json(r.compression)},
          {"warnings", r.warnings},
          {"options", std::move(options)},
          {"seed", r.seed},
          {"versions", std::move(versions)},
          {"run", to_object(r.run)}};
}

/// JSON knows no NaN and no infinity; written as null they would look like a part that does not apply.
void require_finite(const Json& json, const std::string& path) {
  if (json.is_number_float() && !std::isfinite(json.get<double>()))
    throw InvariantError("report: " + path + " is not finite");
  if (json.is_object())
    for (const auto& [key, value] : json.items()) require_finite(value, path.empty() ? key : path + "." + key);
  if (json.is_array())
    for (std::size_t i = 0; i < json.size(); ++i) require_finite(json[i], path + "[" + std::to_string(i) + "]");
}

// The summary.

/// In scene units and, where there is a diagonal, as percentage of it.
std::string length_text(double length, double diagonal) {
  return number(length) + (diagonal > 0 ? " (" + number(100 * length / diagonal) + " %)" : "");
}

std::string topology_text(const Topology& t) {
  std::string text = count_of(t.components, "component") + ", Euler number " + std::to_string(t.euler);
  text += is_closed(t) ? ", closed (genus " + std::to_string(*genus(t)) + ")"
                       : ", " + count_of(t.boundary_loops, "boundary loop");
  if (!t.manifold())
    text += ", NOT MANIFOLD: " + count_of(t.nonmanifold_edges, "edge") + " and " +
            std::to_string(t.nonmanifold_vertices) + " vertices non-manifold, " +
            count_of(t.inconsistent_edges, "edge") + " turned";
  return text;
}

std::string self_intersection_text(const std::optional<std::size_t>& count, std::size_t faces) {
  if (!count) return "";
  return "; " + count_of(*count, "face") + " self-intersecting (" +
         number(faces > 0 ? 100 * static_cast<double>(*count) / static_cast<double>(faces) : 0, 2) + " %)";
}

/// How many loops are open for which reason, and where the longest is.
std::string loops_text(const std::vector<BoundaryLoop>& loops, double diagonal) {
  std::map<std::string, std::size_t> reasons;
  for (const BoundaryLoop& loop : loops) ++reasons[loop.reason];
  std::string text;
  for (const auto& [reason, count] : reasons) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
  const BoundaryLoop& longest = loops.front();
  return text + "; the longest " + length_text(longest.length, diagonal) + " (" + longest.reason + ") around (" +
         number(longest.center.x(), 6) + ", " + number(longest.center.y(), 6) + ", " + number(longest.center.z(), 6) +
         ")";
}

std::string distance_text(const DistanceMeasures& r, double diagonal) {
  const Statistics& s = r.distance;
  return "RMS " + length_text(s.rms, diagonal) + ", mean " + length_text(s.mean, diagonal) + ", median " +
         length_text(s.median, diagonal) + ", 95 % " + length_text(s.p95, diagonal) + ", 99 % " +
         length_text(s.p99, diagonal) + ", max " + length_text(s.max, diagonal) + " at (" + number(r.max_at.x(), 6) +
         ", " + number(r.max_at.y(), 6) + ", " + number(r.max_at.z(), 6) + ")";
}

std::string direction_text(const DirectionMeasures& r, double diagonal) {
  std::string text = distance_text(r.distance, diagonal);
  if (r.normals.count > 0)
    text += "; normals " + number(r.normals.mean, 3) + " deg, 95 % " + number(r.normals.p95, 3) + " deg, " +
            number(100 * r.normals.flipped, 3) + " % flipped";
  if (r.signed_mean) text += "; signed mean " + length_text(*r.signed_mean, diagonal);
  return text;
}

}  // namespace

void note_run(ErrorReport& report, const RunContext& context) {
  report.seed = context.seed;
  report.versions = library_versions();
  report.run.threads = context.thread_count();
  report.run.peak_memory_bytes = peak_memory_bytes();
  if (context.record == nullptr) return;
  context.record->times.stop();
  report.warnings = context.record->warnings;
  report.run.stages = context.record->times.stages();
  report.run.wall_s = context.record->times.total().wall_s;
  report.run.cpu_s = context.record->times.total().cpu_s;
}

ErrorReport report_of(const Comparison& comparison) {
  ErrorReport report;
  report.command = "compare";
  report.diagonal = comparison.diagonal;
  if (comparison.points > 0) report.input = InputReport{{}, comparison.points, comparison.points_diagonal};
  if (comparison.mesh) report.mesh = MeshReport{*comparison.mesh};
  report.points_to_surface = comparison.points_to_surface;
  report.surface_to_points = comparison.surface_to_points;
  report.thresholds = comparison.thresholds;
  if (comparison.reference) report.reference = ReferenceReport{*comparison.reference};
  return report;
}

std::string to_json(const ErrorReport& report) {
  const Json json = to_object(report);
  require_finite(json, "");
  // File names may hold any bytes; what is not UTF-8 is replaced.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string summary(const ErrorReport& r) {
  std::string text;
  const auto line = [&](std::string label, const std::string& content) {
    label.resize(13, ' ');
    text += label + content + "\n";
  };
  const double diagonal = r.diagonal;
  if (r.input) {
    std::string dropped;
    for (const DroppedPoints& d : r.dropped)
      if (d.points > 0) dropped += (dropped.empty() ? "; dropped " : ", ") + std::to_string(d.points) + " " + d.reason;
    line("points", count_of(r.input->points, "point") +
                       (r.input->file.file.empty() ? "" : " from " + r.input->file.file) + dropped + "; diagonal " +
                       number(diagonal, 6));
  }
  if (r.scale)
    line("scale", "spacing " + length_text(r.scale->spacing, diagonal) + ", noise " +
                      length_text(r.scale->noise, diagonal) + ", kernel " + length_text(r.scale->sigma0, diagonal) +
                      (r.scale->choice.empty() ? "" : " (" + r.scale->choice + ")"));
  if (r.scale && r.scale->check) {
    std::string values;
    for (const KernelLikelihood& t : r.scale->check->tried)
      values += (values.empty() ? "" : ", ") + number(t.mean_log_likelihood) + " with " + number(t.factor, 3);
    line("scale check",
         "log-likelihood per held-out point " + values + " automatic kernels; best " + number(r.scale->check->best, 3));
  }
  if (r.mixture)
    line("mixture", std::to_string(r.mixture->components) + " Gaussians" +
                        (r.mixture->levels.empty() ? "" : " after " + count_of(r.mixture->levels.size() - 1, "level")));
  if (r.covmesh) {
    const CovMeshReport& c = *r.covmesh;
    line("covmesh", count_of(c.faces, "face") + " over " + std::to_string(c.vertices) + " vertices, " +
                        topology_text(c.topology) + "; left out " +
                        std::to_string(c.light_components + c.leftover_components) + " Gaussians (" +
                        number(c.light_weight + c.leftover_weight) + " points) and " +
                        count_of(c.dropped_components, "small component") +
                        (c.filled_holes > 0 ? "; filled " + count_of(c.filled_holes, "hole") : "") +
                        self_intersection_text(c.self_intersecting_faces, c.faces));
    if (!c.boundary_loops.empty()) line("open loops", loops_text(c.boundary_loops, diagonal));
  }
  if (r.fit)
    line("fit", count_of(static_cast<std::size_t>(r.fit->steps), "step") + ", vertices moved by " +
                    length_text(r.fit->mean_shift, diagonal) + " on average, " +
                    length_text(r.fit->max_shift, diagonal) + " at most, " + std::to_string(r.fit->added_vertices) +
                    " added where there is more detail");
  if (r.mesh)
    line("mesh", count_of(r.mesh->faces, "face") + " over " + std::to_string(r.mesh->vertices) + " vertices, " +
                     topology_text(r.mesh->topology) +
                     self_intersection_text(r.mesh->self_intersecting_faces, r.mesh->faces));
  if (r.compression)
    line("compression",
         "1 number stored for " + number(r.compression->ratio > 0 ? 1 / r.compression->ratio : 0, 3) + " read");
  if (r.points_to_surface)
    line("points", "to surface: " + distance_text(*r.points_to_surface, diagonal) +
                       (r.surface_to_points
                            ? "; " + number(100 * r.surface_to_points->far, 3) + " % of the surface farther than " +
                                  number(100 * r.thresholds.value().far_rel, 3) + " % from any point"
                            : ""));
  if (r.reference) {
    const ReferenceReport& reference = *r.reference;
    const auto beyond = [&](const DirectionMeasures& d, const char* what) {
      return "; " + std::string(what) + " " + number(100 * d.far, 3) + " % (beyond " +
             number(100 * reference.thresholds.far_rel, 3) + " %)";
    };
    line("reference", "mesh to reference: " + direction_text(reference.mesh_to_reference, reference.diagonal) +
                          beyond(reference.mesh_to_reference, "spurious"));
    line("", "reference to mesh: " + direction_text(reference.reference_to_mesh, reference.diagonal) +
                 beyond(reference.reference_to_mesh, "missing") + "; F-score " + number(reference.f_score()) +
                 " (within " + number(100 * reference.thresholds.fscore_rel, 3) + " %)");
  }
  if (diagonal > 0) line("", "(% of lengths is of the diagonal)");
  if (r.points_to_surface && !r.reference)
    line("blind spot",
         "closeness to the input's own points is consistency, not accuracy: it sees neither errors the "
         "points share nor surface where there are none");
  if (r.run.wall_s > 0)
    line("run", number(r.run.wall_s, 3) + " s, " + number(r.run.cpu_s, 3) + " s of processor time on " +
                    count_of(static_cast<std::size_t>(r.run.threads), "thread") + ", peak memory " +
                    number(static_cast<double>(r.run.peak_memory_bytes) / 1e6, 4) + " MB");
  return text;
}

std::map<std::string, std::string> library_versions() {
  const auto dotted = [](int a, int b, int c) {
    return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
  };
  return {
      {"eigen", dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"nlohmann_json", dotted(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH)},
#ifdef __VERSION__
      {"compiler", __VERSION__},
#endif
  };
}

}  // namespace gpsrecon
