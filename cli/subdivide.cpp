#include <gpsrecon/io/io.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {

ExitCode run_subdivide(Arguments& arguments) {
  std::string in, out;
  ReconstructOptions options;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("COVMESH", in, "covariance mesh (ply; - is standard input)");
  arguments.positional("OUT", out, "mesh (ply, obj, off, stl; - is standard output)");
  bind_subdivide(arguments, options);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  options.check();
  Outputs outputs(globals, {in});
  outputs.plan(out, true);
  const Console console(globals);

  const CovMesh covmesh = load_covmesh(in);
  const RunContext context = console.context();
  ErrorReport report;
  const Mesh mesh = subdivide_stage(covmesh, options, context, report);

  warn_of_losses(mesh, out, console);
  outputs.stage(out, [&](const std::string& path) { write_mesh(mesh, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
