#include <gpsrecon/io/io.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {

ExitCode run_fit(Arguments& arguments) {
  std::string in, points_file, out;
  ScaleOptions scale;
  FitOptions options;
  TriangulateOptions of_sensor;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("COVMESH", in, "covariance mesh (ply; - is standard input)");
  arguments.positional("POINTS", points_file, "the points it was made from (ply, xyz, pcd)");
  arguments.positional("OUT", out, "covariance mesh (ply; - is standard output)");
  bind_points(arguments, scale, nullptr);
  arguments.group("Fit");
  arguments.fields(options);
  arguments.only_fields(of_sensor, {"sensor"});
  GivenRules rules;
  rules.bind(arguments);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  scale.check();
  options.check();
  of_sensor.check();
  if (in == "-" && points_file == "-") throw OptionError("COVMESH and POINTS cannot both be standard input");
  Outputs outputs(globals, {{"COVMESH", in}, {"POINTS", points_file}});
  outputs.plan({"OUT", out});
  const Console console(globals);

  CovMesh mesh = load_covmesh(in);
  require_triangles(mesh, in, "only meshes of triangles are fitted");
  mesh.rules = rules.over(mesh.rules);
  const PointCloud points = load_points(points_file, console);
  const RunContext context = console.context();
  PreparedCloud cloud = on_data_of(points_file, [&] { return prepare(points, scale, context); });
  cloud.sensor = of_sensor.sensor;
  const CovMesh fitted = fit(std::move(mesh), cloud, options, context).mesh;

  outputs.stage(out, [&](const std::string& path) { write_covmesh(fitted, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
