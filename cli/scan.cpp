#include <gpsrecon/io/io.h>
#include <gpsrecon/scan/gallery.h>
#include <gpsrecon/scan/mesh_target.h>
#include <gpsrecon/scan/virtual_scan.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string_view>

#include "bind_options.h"
#include "commands.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {
namespace {

constexpr std::string_view shape_prefix = "shape:";

enum class Normals { none, surface, sensor };

struct ScanFiles {
  std::string surface, out, truth;
  double truth_tolerance_rel = 2e-5;
  Normals normals = Normals::none;
  bool sensors = false;

  bool is_shape() const { return surface.starts_with(shape_prefix); }
};

/// The surface of a command line: a shape, or what a file holds. One of the two pointers in it is set.
struct Surface {
  std::unique_ptr<const Shape> shape;
  std::unique_ptr<const MeshTarget> mesh_target;
  Mesh mesh;  ///< of the file

  const ScanTarget& target() const { return shape ? static_cast<const ScanTarget&>(*shape) : *mesh_target; }
};

std::string shape_names() {
  std::string names;
  for (const GalleryShape& shape : gallery()) names += (names.empty() ? "" : ", ") + shape.name;
  return names;
}

Surface load_surface(const ScanFiles& files) {
  Surface surface;
  if (files.is_shape()) {
    surface.shape = make_shape(files.surface.substr(shape_prefix.size()));
  } else {
    surface.mesh = load_mesh(files.surface);
    surface.mesh_target = on_data_of(files.surface, [&] { return std::make_unique<const MeshTarget>(surface.mesh); });
  }
  return surface;
}

/// A file is its own truth; a shape is triangulated.
Mesh truth_of(const Surface& surface, double tolerance_rel) {
  return surface.shape ? surface.shape->mesh(tolerance_rel * surface.shape->diagonal()) : surface.mesh;
}

/// What goes into the file of the scan. Positions are rounded to `float`, as scanners give them, unless that moves one
/// by more than 1e-6 of the diagonal of the surface.
PointCloud chosen_columns(VirtualScan scan, const ScanFiles& files, double diagonal) {
  PointCloud& cloud = scan.cloud;
  if (files.normals == Normals::none) cloud.normals.clear();
  if (files.normals == Normals::sensor)
    for (std::size_t i = 0; i < cloud.size(); ++i)
      cloud.normals[i] = (cloud.sensors[i] - cloud.positions[i]).normalized();
  if (!files.sensors) cloud.sensors.clear();
  const auto round_to_float = [](std::vector<Vec3>& vectors, double largest_change) {
    const auto rounded = [](const Vec3& v) { return Vec3(v.cast<float>().cast<double>()); };
    for (const Vec3& v : vectors)
      if (!((rounded(v) - v).norm() <= largest_change)) return;
    for (Vec3& v : vectors) v = rounded(v);
  };
  round_to_float(cloud.positions, 1e-6 * diagonal);
  round_to_float(cloud.sensors, 1e-6 * diagonal);
  round_to_float(cloud.normals, 1);
  return std::move(cloud);
}

/// Degrees outside, radians inside.
void bind_angle(Arguments& arguments, const std::string& name, double& radians, const std::string& meaning,
                const std::string& range) {
  constexpr double degree = std::numbers::pi / 180;
  arguments.option(
      name, "DEGREES", meaning, range, std::to_string(std::lround(radians / degree)),
      [&radians](const std::string& text) { radians = parse_double(text) * degree; },
      [&radians] { return OptionValue(radians / degree); });
}

void bind_scan(Arguments& arguments, ScanOptions& options) {
  arguments.group("Scan");
  // Declared first, so that the other options change what it sets, wherever they stand.
  arguments.option(
      "--quality", "s1|s2|s3",
      "start from a grade: s1 is clean and dense, s2 has noise about as wide as its spacing, s3 wider, with "
      "outliers and gaps; the options below change what they name",
      "", "none", [&options](const std::string& text) {
        if (text == "s1")
          options = scan_quality(ScanQuality::s1);
        else if (text == "s2")
          options = scan_quality(ScanQuality::s2);
        else if (text == "s3")
          options = scan_quality(ScanQuality::s3);
        else
          throw OptionError("expected one of s1|s2|s3, got '" + text + "'");
      });
  arguments.option("--points", "N", options.points, "number of points, outliers included", "[1, 2^32 - 2]");
  arguments.option("--views", "N", options.views, "number of cameras, placed evenly around", "[1, 10000]");
  arguments.option("--distance", "X", options.distance,
                   "distance of the cameras from the centre, in radii of a ball around the surface", "(1, 1000]");
  bind_angle(arguments, "--max-incidence", options.max_incidence,
             "largest angle in degrees between ray and surface normal that still gives a point", "(0, 90]");
  arguments.flag("--both-sides", options.both_sides, "measure the back of the surface, too");
  arguments.option("--noise-rel", "X", options.noise_rel,
                   "standard deviation of the measured distance, as a share of the diagonal of the surface", ">= 0");
  arguments.option("--noise-growth", "X", options.noise_growth,
                   "the noise grows towards grazing rays with the power X of 1 / cos(incidence)", "[0, 4]");
  arguments.option(
      "--bias-rel", "X", options.bias_rel,
      "amplitude of an error of the measured distance that varies slowly over each view, as a share of the "
      "diagonal",
      ">= 0");
  arguments.option("--registration-rel", "X", options.registration_shift_rel,
                   "standard deviation of the shift of a view, per axis, as a share of the diagonal", ">= 0");
  bind_angle(arguments, "--registration-angle", options.registration_angle,
             "standard deviation of the rotation of a view in degrees, per axis", "[0, 180]");
  arguments.option("--outliers", "X", options.outlier_share,
                   "share of the points that lie at a random place of their ray", "[0, 1]");
  arguments.option("--spikes", "X", options.spike_share, "share of the points that are moved along their ray",
                   "[0, 1]");
  arguments.option("--spike-rel", "X", options.spike_rel, "by at most this share of the diagonal", ">= 0");
}

}  // namespace

ExitCode run_scan(Arguments& arguments) {
  ScanFiles files;
  ScanOptions options;
  PlyEncoding encoding = PlyEncoding::binary;
  arguments.positional("SURFACE", files.surface,
                       "a mesh (ply, obj, off, stl; - is standard input), or " + std::string(shape_prefix) +
                           "NAME, one of " + shape_names());
  arguments.positional("OUT", files.out, "points (ply; - is standard output)");
  bind_scan(arguments, options);
  bind_encoding(arguments, encoding);
  arguments.choice<Normals>("--normals", files.normals,
                            {{"none", Normals::none}, {"surface", Normals::surface}, {"sensor", Normals::sensor}},
                            "write as normals those of the surface, or the directions to the camera");
  arguments.flag("--sensors", files.sensors, "write where the camera of each point stood");
  arguments.option("--truth", "FILE", files.truth, "write the scanned surface (ply, obj, off, stl, glb), too", "",
                   "none");
  arguments.option("--truth-tolerance-rel", "X", files.truth_tolerance_rel,
                   "largest distance between a shape and the triangles written for it, as a share of the diagonal",
                   "[1e-7, 0.01]");
  const GlobalOptions globals = arguments.parse();
  options.check();
  if (!(files.truth_tolerance_rel >= 1e-7 && files.truth_tolerance_rel <= 0.01))
    throw OptionError("--truth-tolerance-rel: expected a number in [1e-7, 0.01]");
  Outputs outputs(globals, files.is_shape() ? std::vector<std::string>() : std::vector<std::string>{files.surface});
  outputs.plan(files.out);
  outputs.plan(files.truth, true);
  const Console console(globals);

  const Surface surface = load_surface(files);
  const RunContext context = console.context();
  const double diagonal = surface.target().diagonal();
  VirtualScan scan = on_data_of(files.surface, [&] { return virtual_scan(surface.target(), options, context); });
  const PointCloud cloud = chosen_columns(std::move(scan), files, diagonal);

  outputs.stage(files.out, [&](const std::string& path) { write_points(cloud, path, encoding); });
  outputs.stage(files.truth, [&](const std::string& path) {
    write_mesh(truth_of(surface, files.truth_tolerance_rel), path, encoding);
  });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
