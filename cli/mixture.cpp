#include <gpsrecon/core/ellipsoids.h>
#include <gpsrecon/io/io.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {

ExitCode run_mixture(Arguments& arguments) {
  std::string in, out, ellipsoids;
  AttributeOptions attributes;
  ReconstructOptions options;
  EllipsoidOptions ellipsoid_options;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("IN", in, "points (ply, xyz, pcd; - is standard input)");
  arguments.positional("OUT", out, "mixture (ply; - is standard output)");
  bind_scale(arguments, options.scale);
  bind_attributes(arguments, attributes);
  bind_hem(arguments, options);
  arguments.flag("--normals", options.hem.normals,
                 "give each Gaussian a mean normal and its variance, from the normals of the points or, without, from "
                 "planes through their neighbours");
  arguments.group("Output", false);
  arguments.option("--ellipsoids", "FILE", ellipsoids,
                   "write the Gaussians as a mesh of ellipsoids too, to look at (ply, obj, off, stl)", "", "none");
  arguments.option("--ellipsoid-scale", "X", ellipsoid_options.scale, "half axes in standard deviations", "> 0");
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  options.check();
  ellipsoid_options.check();
  Outputs outputs(globals, {in});
  outputs.plan(out);
  outputs.plan(ellipsoids, true);
  const Console console(globals);

  const PointCloud points = load_points(in, console, attributes);
  const RunContext context = console.context();
  ErrorReport report;
  const Mixture mixture =
      on_data_of(in, [&] { return mixture_stage(prepare(points, options.scale, context), options, context, report); });

  outputs.stage(out, [&](const std::string& path) { write_mixture(mixture, path, encoding); });
  outputs.stage(ellipsoids, [&](const std::string& path) {
    write_mesh(ellipsoid_mesh(mixture, ellipsoid_options), path, encoding);
  });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
