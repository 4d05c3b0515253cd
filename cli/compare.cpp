#include <gpsrecon/metrics/compare.h>
#include <gpsrecon/metrics/report.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "commands.h"
#include "console.h"
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

ErrorReport compare_files(const std::string& mesh_file, const std::string& reference_file,
                          const CompareOptions& options, const Console& console) {
  const Mesh mesh = load_mesh(mesh_file);
  if (mesh.faces.empty()) throw InputError(mesh_file + ": holds no faces");
  ErrorReport report;
  if (const FileKind kind = kind_of(reference_file); kind == FileKind::mesh || kind == FileKind::covmesh) {
    report = compare(mesh, load_mesh(reference_file), options, console.context());
    report.reference.value().file = file_report(reference_file);
  } else {
    const PointCloud cloud = finite_points(load_points(reference_file, console), reference_file, console);
    report = compare(mesh, cloud, options, console.context());
    report.input.value().file = file_report(reference_file);
  }
  report.mesh.value().file = file_report(mesh_file);
  return report;
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

}  // namespace

ExitCode run_compare(Arguments& arguments) {
  std::string mesh_file, reference_file, report_file;
  double max_error = INFINITY;
  CompareOptions options;
  arguments.positional("MESH", mesh_file, "the mesh to judge (ply, obj, off, stl; - is standard input)");
  arguments.positional("REFERENCE", reference_file,
                       "a mesh, measured both ways, or points, from which the distance to MESH is measured");
  arguments.group("Comparison");
  arguments.option("--samples", "N", options.samples, "points drawn on each of two meshes, uniform by area",
                   "[1, 1e9]");
  arguments.flag("--self-intersections", options.self_intersections, "count the faces of MESH that intersect others");
  arguments.option("--max-error", "X",
                   "exit with code 7 if the largest distance, either way, is above X, in the unit of the coordinates",
                   ">= 0", "no limit", [&max_error](const std::string& text) {
                     max_error = parse_double(text);
                     if (max_error < 0) throw OptionError("expected a number >= 0, got '" + text + "'");
                   });
  arguments.group("Output", false);
  arguments.option("--report", "FILE", report_file, "report (JSON; - is standard output)", "", "none");
  const GlobalOptions globals = arguments.parse();
  options.check();
  if (mesh_file == "-" && reference_file == "-") throw OptionError("MESH and REFERENCE cannot both be standard input");
  Outputs outputs(globals, {mesh_file, reference_file});
  outputs.plan(report_file);
  const Console console(globals);

  ErrorReport report = compare_files(mesh_file, reference_file, options, console);
  report.version = GPSRECON_VERSION;
  report.command = "compare";
  report.seed = globals.seed;
  report.options = arguments.values();

  outputs.stage(report_file, [&](const std::string& path) { write_text(to_json(report), path); });
  outputs.commit(console.context());
  if (!globals.quiet) std::fputs(summary(report).c_str(), stderr);
  if (const double largest = largest_distance(report); largest > max_error) {
    console.warn("the largest distance, " + std::to_string(largest) + ", is above " + std::to_string(max_error));
    return ExitCode::max_error_exceeded;
  }
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
