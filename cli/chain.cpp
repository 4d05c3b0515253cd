#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/version.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/measure/compare.h>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

#include "bind_options.h"
#include "commands.h"
#include "error_views.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {
namespace {

struct ChainFiles {
  std::string in, out;  // positional
  std::string covmesh, report, dump;
  bool no_covmesh = false, no_report = false;

  static OptionTable fields() {
    using O = ChainFiles;
    return {field<&O::covmesh>("covmesh", "", "covariance mesh (ply)").or_else("OUT's stem + .covmesh.ply"),
            field<&O::report>("report", "", "report (JSON)").or_else("OUT's stem + .report.json"),
            field<&O::no_covmesh>("no-covmesh", "", "write no covariance mesh"),
            field<&O::no_report>("no-report", "", "write no report"),
            field<&O::dump>("dump", "",
                            "keep every level of the mixture (level-NN.mixture.ply) and snapshots of the triangulation "
                            "(front-NNNNNNNN.mesh.ply) in the folder FILE, which is made if its parent exists")};
  }
};

/// Companions of OUT that were not named lie beside it; beside standard output there is no place.
void complete(ChainFiles& files) {
  if (files.no_covmesh && !files.covmesh.empty()) throw OptionError("--covmesh and --no-covmesh contradict each other");
  if (files.no_report && !files.report.empty()) throw OptionError("--report and --no-report contradict each other");
  if (files.out == "-") return;
  if (files.covmesh.empty() && !files.no_covmesh) files.covmesh = beside(files.out, ".covmesh.ply");
  if (files.report.empty() && !files.no_report) files.report = beside(files.out, ".report.json");
}

/// Numbered files in the folder of --dump.
struct DumpedFiles {
  std::string_view stem;
  std::size_t digits;  ///< at least
  std::string_view ending;

  std::string name(std::size_t number) const {
    const std::string text = std::to_string(number);
    const std::string zeros(std::max(digits, text.size()) - text.size(), '0');
    return std::string(stem) + zeros + text + std::string(ending);
  }
  bool has(std::string_view name) const { return name.starts_with(stem) && name.ends_with(ending); }
};
constexpr DumpedFiles dumped_levels{"level-", 2, ".mixture.ply"}, dumped_fronts{"front-", 8, ".mesh.ply"};

/// Hooks the stages to keep what is between input and output: each level as a mixture, the growing front as a mesh of
/// the means of the last level.
void dump_levels_and_fronts(const std::string& folder, ReconstructOptions& options, Outputs& outputs,
                            PlyEncoding encoding) {
  if (folder.empty()) return;
  const auto file = [folder](const DumpedFiles& kind, std::size_t number) {
    return (std::filesystem::path(folder) / kind.name(number)).string();
  };
  const auto last_level = std::make_shared<Mixture>();
  options.hem.on_level = [=, &outputs](int level, const Mixture& mixture) {
    *last_level = mixture;
    outputs.stage(file(dumped_levels, static_cast<std::size_t>(level)),
                  [&](const std::string& path) { write_mixture(mixture, path, encoding); });
  };
  options.triangulate.on_snapshot = [=, &outputs](std::size_t step, const FaceList& faces) {
    Mesh mesh;
    mesh.positions = last_level->means;
    mesh.faces = faces;
    mesh.frame = last_level->frame;
    outputs.stage(file(dumped_fronts, step), [&](const std::string& path) { write_mesh(mesh, path, encoding); });
  };
}

/// Leaves the points it read, if it did, in `points` if that is not null.
Reconstruction reconstruct_file(const std::string& path, const AttributeOptions& attributes,
                                const ReconstructOptions& options, const GivenRules& rules, const Console& console,
                                PointCloud* points) {
  const RunContext context = console.context();
  context.begin("read");
  const auto work_on = [&](const auto& data) {
    return on_data_of(path, [&] { return reconstruct(data, options, context); });
  };
  switch (kind_of(path)) {
    case FileKind::mixture: {
      console.info(path + ": is a mixture; starting with the triangulation");
      const Mixture mixture = load_mixture(path);
      if (options.hem.on_level) options.hem.on_level(0, mixture);
      return work_on(mixture);
    }
    case FileKind::covmesh:
      console.info(path + ": is a covariance mesh; starting with the subdivision");
      { return work_on(rules.over(load_covmesh(path), path)); }
    case FileKind::points:
    case FileKind::mesh:
      break;
  }
  PointCloud cloud = load_points(path, console, attributes);
  Reconstruction result = work_on(cloud);
  if (points != nullptr) *points = std::move(cloud);
  return result;
}

}  // namespace

ExitCode run_chain(Arguments& arguments) {
  ChainFiles files;
  AttributeOptions attributes;
  ReconstructOptions options;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("IN", files.in,
                       "points (ply, xyz, pcd), also a mesh, whose vertices are taken; a mixture or a covariance mesh "
                       "enters the chain at its stage (- is standard input)");
  arguments.positional("OUT", files.out, "mesh (ply, obj, off, stl, glb; - is standard output)");
  bind_points(arguments, options.scale, &attributes);
  bind_chain_projection(arguments, options);
  bind_mixture(arguments, options.hem);
  arguments.only_fields(options, {"budget", "max-error", "check-scale"});
  arguments.group("Triangulation");
  arguments.fields(options.triangulate);
  arguments.group("Fit");
  arguments.fields(options.fit);
  arguments.flag("--no-fit", "the same as --fit-steps 0", [&options] { options.fit.steps = 0; });
  arguments.group("Subdivision");
  arguments.fields(options.subdivide);
  GivenRules rules;
  rules.bind(arguments, options.triangulate.rules);
  arguments.group("Output", false);
  arguments.fields(files);
  arguments.only_fields(options, {"self-intersections"});
  ErrorViews views;
  arguments.fields(views);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  options.triangulate.rules = rules.over(options.triangulate.rules);
  options.check();
  check_fields(views);
  complete(files);
  Outputs outputs(globals, {{"IN", files.in}});
  outputs.plan({"OUT", files.out}, true);
  outputs.plan({"--covmesh", files.covmesh});
  outputs.plan({"--report", files.report});
  outputs.plan_folder({"--dump", files.dump},
                      [](const std::string& name) { return dumped_levels.has(name) || dumped_fronts.has(name); });
  views.plan(outputs);
  const Console console(globals);
  dump_levels_and_fronts(files.dump, options, outputs, encoding);

  const RunContext context = console.context();
  PointCloud points;
  Reconstruction result =
      reconstruct_file(files.in, attributes, options, rules, console, views.wanted() ? &points : nullptr);
  ErrorReport& report = result.report;
  report.version = version;
  report.options = arguments.values();
  warn_of_losses(result.mesh, files.out, console);
  if (report.input) report.input->file = file_report(files.in);

  context.begin("write");
  outputs.stage(files.out, [&](const std::string& path) { write_mesh(result.mesh, path, encoding); });
  outputs.stage(files.covmesh, [&](const std::string& path) { write_covmesh(result.covmesh, path, encoding); });
  note_run(report, context);
  if (views.wanted()) {
    if (points.empty()) throw OptionError("--heatmap and --html need points, which " + files.in + " does not hold");
    const PreparedCloud kept = prepare(points, options.scale, context);
    const Mesh mesh = in_frame(result.mesh, kept.cloud.frame);
    views.stage(
        outputs, report, mesh, [&](double range) { return error_map(mesh, kept.cloud, range, context); }, files.in,
        console);
  }
  outputs.stage(files.report, [&](const std::string& path) { write_text(to_json(report), path); });
  outputs.commit(context);
  if (!globals.quiet) std::fputs(summary(report).c_str(), stderr);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
