#include <gpsrecon/io/io.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"
#include "repair.h"

namespace gpsrecon::cli {
namespace {

struct SubdivideFiles {
  std::string points;

  static OptionTable fields() {
    return {field<&SubdivideFiles::points>("points", "",
                                           "the points it was made from (ply, xyz, pcd), to take colours and scalars "
                                           "from as the chain does, instead of the coarser ones of the Gaussians")};
  }
};

}  // namespace

ExitCode run_subdivide(Arguments& arguments) {
  std::string in, out;
  SubdivideFiles files;
  AttributeOptions attributes;
  ScaleOptions scale;
  SubdivideOptions options;
  RepairOptions repair;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("COVMESH", in, "covariance mesh (ply; - is standard input)");
  arguments.positional("OUT", out, "mesh (ply, obj, off, stl, glb; - is standard output)");
  arguments.group("Subdivision");
  arguments.fields(options);
  GivenRules rules;
  rules.bind(arguments);
  bind_points(arguments, scale, &attributes);
  arguments.group("Input");
  arguments.fields(files);
  arguments.fields(repair);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  scale.check();
  options.check();
  if (in == "-" && files.points == "-") throw OptionError("COVMESH and --points cannot both be standard input");
  Outputs outputs(globals, {{"COVMESH", in}, {"--points", files.points}});
  outputs.plan({"OUT", out}, true);
  const Console console(globals);

  const CovMesh covmesh = rules.over(load_covmesh(in, repair.repair, console), in);
  const RunContext context = console.context();
  std::optional<PreparedCloud> cloud;
  if (!files.points.empty()) {
    const PointCloud points = load_points(files.points, console, attributes);
    cloud = on_data_of(files.points, [&] { return prepare(points, scale, context); });
  }
  const Mesh mesh = cloud ? subdivide(covmesh, *cloud, options, context) : subdivide(covmesh, options, context);

  warn_of_losses(mesh, out, console);
  outputs.stage(out, [&](const std::string& path) { write_mesh(mesh, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
