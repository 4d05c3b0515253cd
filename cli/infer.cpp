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
  RepairOptions repair;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("MESH", in, "mesh of triangles or polygons (ply, obj, off, stl; - is standard input)");
  arguments.positional("OUT", out, "covariance mesh (ply; - is standard output)");
  arguments.group("Inference");
  arguments.fields(options);
  arguments.fields(repair);
  GivenRules rules;
  rules.bind(arguments);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  options.check();
  Outputs outputs(globals, {{"MESH", in}});
  outputs.plan({"OUT", out});
  const Console console(globals);

  const Mesh mesh = repair.repair ? repaired(load_soup(in), in, console) : load_mesh(in);
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
