#include <gpsrecon/core/ellipsoids.h>
#include <gpsrecon/io/io.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {

using namespace internal;
namespace {

struct MixtureFiles {
  std::string ellipsoids;

  static OptionTable fields() {
    return {field<&MixtureFiles::ellipsoids>("ellipsoids", "",
                                             "write the Gaussians as a mesh of ellipsoids too, to look at, coloured by "
                                             "their smallest axis (ply, obj, off, stl, glb)")};
  }
};

}  // namespace

ExitCode run_mixture(Arguments& arguments) {
  std::string in, out;
  MixtureFiles files;
  AttributeOptions attributes;
  ScaleOptions scale;
  HemOptions options;
  EllipsoidOptions ellipsoid_options;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("IN", in, "points (ply, xyz, pcd; - is standard input)");
  arguments.positional("OUT", out, "mixture (ply; - is standard output)");
  bind_points(arguments, scale, &attributes);
  bind_mixture(arguments, options);
  arguments.group("Output", false);
  arguments.only_fields(options, {"normals"});
  arguments.fields(files);
  arguments.fields(ellipsoid_options);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  scale.check();
  options.check();
  ellipsoid_options.check();
  Outputs outputs(globals, {{"IN", in}});
  outputs.plan({"OUT", out});
  outputs.plan({"--ellipsoids", files.ellipsoids}, true);
  const Console console(globals);

  const PointCloud points = load_points(in, console, attributes);
  const RunContext context = console.context();
  const Mixture mixture =
      on_data_of(in, [&] { return build_mixture(prepare(points, scale, context), options, context).mixture; });

  outputs.stage(out, [&](const std::string& path) { write_mixture(mixture, path, encoding); });
  outputs.stage(files.ellipsoids, [&](const std::string& path) {
    write_mesh(ellipsoid_mesh(mixture, ellipsoid_options), path, encoding);
  });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
