#include <gpsrecon/io/io.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"
#include "repair.h"

namespace gpsrecon::cli {

ExitCode run_subdivide(Arguments& arguments) {
  std::string in, out, points_file;
  AttributeOptions attributes;
  ReconstructOptions options;
  bool repair = false;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("COVMESH", in, "covariance mesh (ply; - is standard input)");
  arguments.positional("OUT", out, "mesh (ply, obj, off, stl, glb; - is standard output)");
  bind_subdivide(arguments, options);
  GivenRules rules;
  rules.bind(arguments);
  bind_repair(arguments, repair);
  bind_scale(arguments, options.scale);
  arguments.option("--points", "FILE", points_file,
                   "the points it was made from (ply, xyz, pcd), to take colours and scalars from instead of from the "
                   "Gaussians",
                   "", "none");
  bind_attributes(arguments, attributes);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  options.check();
  if (in == "-" && points_file == "-") throw OptionError("COVMESH and --points cannot both be standard input");
  std::vector<std::string> inputs{in};
  if (!points_file.empty()) inputs.push_back(points_file);
  Outputs outputs(globals, inputs);
  outputs.plan(out, true);
  const Console console(globals);

  const CovMesh covmesh = rules.over(load_covmesh(in, repair, console), in);
  const RunContext context = console.context();
  ErrorReport report;
  std::optional<PreparedCloud> cloud;
  if (!points_file.empty()) {
    const PointCloud points = load_points(points_file, console, attributes);
    cloud = on_data_of(points_file, [&] { return prepare(points, options.scale, context); });
  }
  const Mesh mesh = cloud ? subdivide_stage(covmesh, *cloud, options, context, report)
                          : subdivide_stage(covmesh, options, context, report);

  warn_of_losses(mesh, out, console);
  outputs.stage(out, [&](const std::string& path) { write_mesh(mesh, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
