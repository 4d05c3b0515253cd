#include <gpsrecon/io/io.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {

ExitCode run_triangulate(Arguments& arguments) {
  std::string in, out;
  TriangulateOptions options;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("MIXTURE", in, "mixture (ply; - is standard input)");
  arguments.positional("OUT", out, "covariance mesh (ply; - is standard output)");
  arguments.group("Triangulation");
  arguments.fields(options);
  GivenRules rules;
  rules.bind(arguments, options.rules);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  options.rules = rules.over(options.rules);
  options.check();
  Outputs outputs(globals, {{"MIXTURE", in}});
  outputs.plan({"OUT", out});
  const Console console(globals);

  const Mixture mixture = load_mixture(in);
  const RunContext context = console.context();
  const CovMesh mesh = on_data_of(in, [&] { return triangulate(mixture, options, context).mesh; });

  outputs.stage(out, [&](const std::string& path) { write_covmesh(mesh, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
