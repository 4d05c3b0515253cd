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

struct ProjectOutput {
  bool no_normals = false;

  static OptionTable fields() { return {field<&ProjectOutput::no_normals>("no-normals", "", "write no normals")}; }
};

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
  ProjectOutput output;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("IN", in, "points (ply, xyz, pcd; - is standard input)");
  arguments.positional("OUT", out, "projected particles with normals (ply; - is standard output)");
  bind_points(arguments, scale, &attributes);
  arguments.group("Projection");
  arguments.fields(options);
  arguments.fields(options.particles);
  arguments.fields(options.project);
  arguments.group("Mixture of --method clop");
  arguments.only_fields(options.hem, {"sigma0", "alpha", "hem-levels", "balance"});
  bind_encoding(arguments, encoding);
  arguments.fields(output);
  const GlobalOptions globals = arguments.parse();
  scale.check();
  options.check();
  Outputs outputs(globals, {{"IN", in}});
  outputs.plan({"OUT", out});
  const Console console(globals);

  const PointCloud points = load_points(in, console, attributes);
  const RunContext context = console.context();
  PointCloud particles = on_data_of(in, [&] {
    const PreparedCloud cloud = prepare(points, scale, context);
    return in_frame(project_points(cloud, options, context), Frame{});
  });
  if (!output.no_normals) particles = with_normals(std::move(particles), context);

  outputs.stage(out, [&](const std::string& path) { write_points(particles, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
