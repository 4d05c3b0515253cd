#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/pipeline/point_normals.h>
#include <gpsrecon/pipeline/projection.h>
#include <gpsrecon/pipeline/reconstruct.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {
namespace {

/// Particles so few that they have no normals are written without.
PointCloud with_normals(PointCloud particles, const RunContext& context) {
  try {
    return point_normals(particles, {}, {}, context);
  } catch (const NoSurfaceError& error) {
    context.warn("no normals: " + std::string(error.what()));
    return particles;
  }
}

}  // namespace

ExitCode run_project(Arguments& arguments) {
  std::string in, out;
  AttributeOptions attributes;
  ScaleOptions scale;
  ProjectionOptions options;
  bool no_normals = false;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("IN", in, "points (ply, xyz, pcd; - is standard input)");
  arguments.positional("OUT", out, "projected particles with normals (ply; - is standard output)");
  bind_scale(arguments, scale);
  bind_attributes(arguments, attributes);
  bind_projection(arguments, options);
  bind_encoding(arguments, encoding);
  arguments.flag("--no-normals", no_normals, "write no normals");
  const GlobalOptions globals = arguments.parse();
  scale.check();
  options.check();
  Outputs outputs(globals, {in});
  outputs.plan(out);
  const Console console(globals);

  const PointCloud points = load_points(in, console, attributes);
  const RunContext context = console.context();
  PointCloud particles = on_data_of(in, [&] {
    const PreparedCloud cloud = prepare(points, scale, context);
    return in_frame(project_points(cloud.clean.cloud, cloud.scale, cloud.diagonal, options, context), Frame{});
  });
  if (!no_normals) particles = with_normals(std::move(particles), context);

  outputs.stage(out, [&](const std::string& path) { write_points(particles, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
