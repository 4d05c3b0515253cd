#include <gpsrecon/gps/infer.h>
#include <gpsrecon/io/io.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"
#include "repair.h"

namespace gpsrecon::cli {
namespace {

void tell(const Inference& inferred, const std::string& in, const Console& console) {
  console.info("infer: " + std::to_string(inferred.mesh.vertices.size()) + " Gaussians, " +
               std::to_string(inferred.degenerate_faces) + " degenerate faces, " +
               std::to_string(inferred.vertices_without_neighborhood) + " vertices without a proper face");
  if (inferred.degenerate_faces > 0)
    console.warn(in + ": " + std::to_string(inferred.degenerate_faces) +
                 " faces have no area and say nothing about covariances");
  if (inferred.vertices_without_neighborhood > 0)
    console.warn(in + ": " + std::to_string(inferred.vertices_without_neighborhood) +
                 " vertices are in no face with an area; they were given what their neighbours have");
}

}  // namespace

ExitCode run_infer(Arguments& arguments) {
  std::string in, out;
  InferOptions options;
  bool bias_given = false, repair = false;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("MESH", in, "mesh of triangles or polygons (ply, obj, off, stl; - is standard input)");
  arguments.positional("OUT", out, "covariance mesh (ply; - is standard output)");
  arguments.group("Inference");
  arguments.choice<InferMethod>(
      "--method", options.method, {{"face", InferMethod::face}, {"vertex", InferMethod::vertex}},
      "covariance of a vertex: of the product of the Gaussians of its faces, which keeps features, or of its "
      "neighbours");
  arguments.option("--bias", "X",
                   "variance added in all directions, in multiples of the largest of the face (or neighbourhood): the "
                   "larger, the smoother",
                   "[1e-9, 1000]", "0.05", [&](const std::string& text) {
                     options.bias = parse_double(text);
                     bias_given = true;
                   });
  arguments.option("--sigma0", "X", options.sigma0,
                   "standard deviation added in all directions, in the unit of the coordinates, instead of --bias; "
                   "0 = as --bias says",
                   "> 0 or 0");
  GivenRules rules;
  rules.bind(arguments);
  bind_repair(arguments, repair);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  if (bias_given && options.sigma0 != 0) throw OptionError("--bias and --sigma0 exclude each other");
  options.check();
  Outputs outputs(globals, {in});
  outputs.plan(out);
  const Console console(globals);

  const Mesh mesh = repair ? repaired(load_soup(in), in, console) : load_mesh(in);
  const RunContext context = console.context();
  Inference inferred = on_data_of(in, [&] {
    try {
      return infer_covariances(mesh, options, context);
    } catch (const InvariantError& error) {
      throw InputError(error.what());
    }
  });
  tell(inferred, in, console);
  const CovMesh covmesh = rules.over(std::move(inferred.mesh), in);

  outputs.stage(out, [&](const std::string& path) { write_covmesh(covmesh, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
