#include <gpsrecon/io/io.h>
#include <gpsrecon/pipeline/point_normals.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {
namespace {

struct NormalFiles {
  std::string in, out;  // positional
  std::string surface, mixture;

  static OptionTable fields() {
    using O = NormalFiles;
    return {field<&O::mixture>("mixture", "",
                               "with --method csw: a mixture with normals, instead of one made of the points"),
            field<&O::surface>("surface", "", "mesh that decides the side (ply, obj, off, stl)")};
  }
};

void bind_normals(Arguments& arguments, PointNormalsOptions& options, NormalFiles& files) {
  arguments.group("Normals");
  arguments.only_fields(options, {"method", "support-radius"});
  arguments.fields(options.normals);
  arguments.only_fields(files, {"mixture"});
  arguments.group("Orientation");
  arguments.only_fields(options, {"orient", "sensor"});
  arguments.only_fields(files, {"surface"});
  arguments.fields(options.propagation);
}

void refuse_contradictions(const NormalFiles& files, const PointNormalsOptions& options) {
  if (!files.mixture.empty() && options.method != NormalMethod::csw)
    throw OptionError("--mixture: only --method csw takes normals from a mixture");
  if (!files.surface.empty() && options.orientation != NormalOrientation::automatic &&
      options.orientation != NormalOrientation::surface)
    throw OptionError("--surface: contradicts --orient, which is neither auto nor surface");
  int standard_inputs = 0;
  for (const std::string& file : {files.in, files.surface, files.mixture}) standard_inputs += file == "-" ? 1 : 0;
  if (standard_inputs > 1) throw OptionError("only one input can be standard input");
}

Mixture load_mixture_with_normals(const std::string& path) {
  Mixture mixture = load_mixture(path);
  if (mixture.normals.empty())
    throw InputError(path + ": the mixture has no normals (columns nvx nvy nvz; gpsrecon mixture --normals)");
  return mixture;
}

}  // namespace

ExitCode run_normals(Arguments& arguments) {
  NormalFiles files;
  PointNormalsOptions options;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("IN", files.in, "points (ply, xyz, pcd; - is standard input)");
  arguments.positional("OUT", files.out, "points with normals (ply; - is standard output)");
  bind_points(arguments, options.scale, nullptr);
  bind_normals(arguments, options, files);
  bind_mixture(arguments, options.mixture);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  options.check();
  refuse_contradictions(files, options);
  Outputs outputs(globals, {{"IN", files.in}, {"--surface", files.surface}, {"--mixture", files.mixture}});
  outputs.plan({"OUT", files.out});
  const Console console(globals);

  const PointCloud points = load_points(files.in, console);
  NormalSources sources;
  std::optional<Mesh> surface;
  std::optional<Mixture> mixture;
  if (!files.surface.empty()) {
    surface = load_mesh(files.surface);
    if (surface->faces.empty()) throw InputError(files.surface + ": holds no faces");
    sources.surface = &*surface;
  }
  if (!files.mixture.empty()) {
    mixture = load_mixture_with_normals(files.mixture);
    sources.mixture = &*mixture;
  }
  const RunContext context = console.context();
  const PointCloud cloud = on_data_of(files.in, [&] { return point_normals(points, options, sources, context); });

  outputs.stage(files.out, [&](const std::string& path) { write_points(cloud, path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
