#include <gpsrecon/io/io.h>
#include <gpsrecon/pipeline/point_normals.h>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {
namespace {

struct NormalFiles {
  std::string in, out, surface, mixture;
};

void bind_normals(Arguments& arguments, PointNormalsOptions& options, NormalFiles& files) {
  arguments.group("Normals");
  arguments.choice<NormalMethod>(
      "--method", options.method,
      {{"pca", NormalMethod::pca}, {"weiszfeld", NormalMethod::weiszfeld}, {"csw", NormalMethod::csw}},
      "planes through the nearest points, the spherical medians of their normals around each point, or those of a "
      "mixture of the points");
  arguments.option("--neighbors", "K", options.normals.neighbors,
                   "points a plane is put through, 0 = automatic: 12, more where noise asks for it", "[3, 1000] or 0");
  arguments.option("--h-rel", "X", options.h_rel,
                   "radius within which medians are taken, as a share of the diagonal, 0 = automatic", "(0, 1] or 0");
  arguments.option("--iterations", "N", options.normals.iterations, "steps towards the median, at most", "[0, 1000]");
  arguments.option("--convergence", "X", options.normals.convergence, "stop when a normal turns by less than X radians",
                   ">= 0");
  arguments.option("--mixture", "FILE", files.mixture,
                   "with --method csw: a mixture with normals, instead of one made of the points", "", "none");
  arguments.group("Orientation");
  arguments.choice<NormalOrientation>("--orient", options.orientation,
                                      {{"auto", NormalOrientation::automatic},
                                       {"none", NormalOrientation::none},
                                       {"surface", NormalOrientation::surface},
                                       {"sensor", NormalOrientation::sensor},
                                       {"mst", NormalOrientation::neighbors}},
                                      "side of the normals: arbitrary, of the nearest face of --surface, of the sensor "
                                      "(--sensor or columns sx sy sz), or from neighbour to neighbour along a minimum "
                                      "spanning tree, then outward; auto takes the first of the last three at hand");
  arguments.option("--surface", "MESH", files.surface, "mesh that decides the side (ply, obj, off, stl)", "", "none");
  arguments.option("--sensor", "X,Y,Z", "where the sensor stood, in the coordinates of the input", "", "unknown",
                   [&options](const std::string& text) { options.sensor = parse_point(text); });
  arguments.option("--orient-neighbors", "K", options.propagation.neighbors,
                   "nearest points that a point is linked with in the tree", "[1, 1000]");
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
  bind_scale(arguments, options.scale);
  bind_normals(arguments, options, files);
  bind_hem(arguments, options.mixture);
  bind_encoding(arguments, encoding);
  const GlobalOptions globals = arguments.parse();
  options.check();
  refuse_contradictions(files, options);
  Outputs outputs(globals, {files.in, files.surface, files.mixture});
  outputs.plan(files.out);
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
