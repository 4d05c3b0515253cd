#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/version.h>
#include <gpsrecon/gps/subdivide.h>
#include <gpsrecon/measure/align.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/report/report.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "commands.h"
#include "console.h"
#include "error_views.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {
namespace {

/// Only finite points can be measured; a reference of points may have others, as a scan may.
PointCloud finite_points(const PointCloud& cloud, const std::string& path, const Console& console) {
  std::vector<Index> keep;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.positions[i].allFinite()) keep.push_back(static_cast<Index>(i));
  if (keep.empty()) throw InputError(path + ": holds no finite point");
  if (keep.size() < cloud.size())
    console.warn(path + ": " + std::to_string(cloud.size() - keep.size()) + " points are not finite and do not count");
  return select(cloud, keep);
}

/// A file to be compared: a mesh, the limit surface of a covariance mesh, or points.
struct Shape {
  FileKind kind = FileKind::points;
  Mesh mesh;
  PointCloud cloud;
  bool is_mesh() const { return kind == FileKind::mesh || kind == FileKind::covmesh; }
};

/// Covariance meshes are refined to limit positions at this level.
constexpr int surface_level = 2;

Shape load_shape(const std::string& path, const Console& console) {
  Shape shape;
  shape.kind = kind_of(path);
  switch (shape.kind) {
    case FileKind::covmesh:
      console.info(path + ": is a covariance mesh; its surface is compared, refined " + std::to_string(surface_level) +
                   " times");
      shape.mesh = subdivide(load_covmesh(path), {.levels = surface_level}, console.context());
      break;
    case FileKind::mesh:
      shape.mesh = load_mesh(path);
      if (shape.mesh.faces.empty()) throw InputError(path + ": holds no faces");
      break;
    case FileKind::points:
    case FileKind::mixture:
      shape.cloud = finite_points(load_points(path, console), path, console);
      break;
  }
  return shape;
}

Comparison compare_shapes(const Shape& judged, const Shape& reference, const CompareOptions& options,
                          const RunContext& context) {
  if (judged.is_mesh())
    return reference.is_mesh() ? compare(judged.mesh, reference.mesh, options, context)
                               : compare(judged.mesh, reference.cloud, options, context);
  return reference.is_mesh() ? compare(judged.cloud, reference.mesh, options, context)
                             : compare(judged.cloud, reference.cloud, options, context);
}

/// Brings what is judged onto the reference.
Alignment align_shape(Shape& judged, const Shape& reference, const Console& console) {
  const RunContext context = console.context();
  Alignment motion;
  if (judged.is_mesh()) {
    motion = reference.is_mesh() ? align(judged.mesh, reference.mesh, {}, context)
                                 : align(judged.mesh, reference.cloud, {}, context);
    judged.mesh = moved_by(judged.mesh, motion);
  } else {
    motion = reference.is_mesh() ? align(judged.cloud, reference.mesh, {}, context)
                                 : align(judged.cloud, reference.cloud, {}, context);
    judged.cloud = moved_by(judged.cloud, motion);
  }
  console.info("aligned in " + std::to_string(motion.iterations) + " steps: root mean square distance " +
               std::to_string(motion.rms_before) + " -> " + std::to_string(motion.rms_after));
  if (!motion.converged)
    console.warn("the alignment was still moving after " + std::to_string(motion.iterations) + " steps");
  return motion;
}

/// The largest distance, either way where both were measured.
double largest_distance(const ErrorReport& report) {
  double largest = 0;
  if (report.points_to_surface) largest = std::max(largest, report.points_to_surface->distance.max);
  if (report.reference)
    largest = std::max({largest, report.reference->mesh_to_reference.distance.distance.max,
                        report.reference->reference_to_mesh.distance.distance.max});
  return largest;
}

/// What the command does beside the comparison.
struct CompareActions {
  bool align = false;
  std::optional<Length> max_error = {};
  std::string report;

  static OptionTable fields() {
    using O = CompareActions;
    return {
        field<&O::align>("align", "",
                         "first bring SHAPE onto REFERENCE by a rigid motion, from where it lies: it has to lie about "
                         "right"),
        field<&O::max_error>("max-error", ">= 0",
                             "exit with code 7 if the largest distance, either way, is above LENGTH; against points "
                             "only the way from them counts"),
        field<&O::report>("report", "", "report (JSON; - is standard output)")};
  }
};

}  // namespace

ExitCode run_compare(Arguments& arguments) {
  std::string judged_file, reference_file;
  CompareActions actions;
  CompareOptions options;
  ErrorViews views;
  arguments.positional(
      "SHAPE", judged_file,
      "what is judged: a mesh (ply, obj, off, stl), a covariance mesh, or points (- is standard input)");
  arguments.positional("REFERENCE", reference_file, "the same; both ways are measured");
  arguments.group("Comparison");
  arguments.fields(options);
  arguments.only_fields(actions, {"align", "max-error"});
  arguments.group("Output", false);
  arguments.only_fields(actions, {"report"});
  arguments.fields(views);
  const GlobalOptions globals = arguments.parse();
  options.check();
  check_fields(actions);
  check_fields(views);
  if (judged_file == "-" && reference_file == "-")
    throw OptionError("SHAPE and REFERENCE cannot both be standard input");
  Outputs outputs(globals, {{"SHAPE", judged_file}, {"REFERENCE", reference_file}});
  outputs.plan({"--report", actions.report});
  views.plan(outputs);
  const Console console(globals);

  const RunContext context = console.context();
  Shape judged = load_shape(judged_file, console);
  const Shape reference = load_shape(reference_file, console);
  if (views.wanted() && !judged.is_mesh())
    throw OptionError("--heatmap and --html show a mesh; " + judged_file + " holds points");
  if (options.self_intersections && !judged.is_mesh())
    throw OptionError("--self-intersections needs a mesh; " + judged_file + " holds points");
  std::optional<Alignment> motion;
  if (actions.align) motion = align_shape(judged, reference, console);
  ErrorReport report = report_of(compare_shapes(judged, reference, options, context));
  if (report.mesh) report.mesh->file = file_report(judged_file);
  if (report.reference) report.reference->file = file_report(reference_file);
  if (report.input) report.input->file = file_report(report.reference ? judged_file : reference_file);
  report.alignment = motion;
  report.version = version;
  report.seed = globals.seed;
  report.options = arguments.values();

  outputs.stage(actions.report, [&](const std::string& path) { write_text(to_json(report), path); });
  const Frame& frame = reference.is_mesh() ? reference.mesh.frame : reference.cloud.frame;
  const Mesh shown = views.wanted() ? in_frame(judged.mesh, frame) : judged.mesh;
  views.stage(
      outputs, report, shown,
      [&](double range) {
        return reference.is_mesh() ? error_map(shown, reference.mesh, range, context)
                                   : error_map(shown, reference.cloud, range, context);
      },
      judged_file + " against " + reference_file, console);
  outputs.commit(context);
  if (!globals.quiet) std::fputs(summary(report).c_str(), stderr);
  if (!actions.max_error) return ExitCode::done;
  const double limit = actions.max_error->resolve({.diagonal = report.diagonal}, "max-error");
  if (const double largest = largest_distance(report); largest > limit) {
    console.warn("the largest distance, " + std::to_string(largest) + ", is above " + actions.max_error->text());
    return ExitCode::max_error_exceeded;
  }
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
