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

using namespace internal;
namespace {

constexpr std::string_view shape_prefix = "shape:";

enum class Normals { none, surface, sensor };
constexpr std::array<std::string_view, 3> option_names(Normals /*type*/) {
  return {"none", "surface", "sensor"};
}

struct ScanFiles {
  std::string surface, out;  // positional
  std::string truth;
  Length truth_tolerance = Length::of_diagonal(2e-5);
  Normals normals = Normals::none;
  bool sensors = false;

  static OptionTable fields() {
    using O = ScanFiles;
    return {
        field<&O::normals>("normals", "", "write as normals those of the surface, or the directions to the camera"),
        field<&O::sensors>("sensors", "", "write where the camera of each point stood"),
        field<&O::truth>("truth", "", "write the scanned surface (ply, obj, off, stl, glb), too"),
        field<&O::truth_tolerance>("truth-tolerance", "> 0",
                                   "largest distance between a shape and the triangles written for it, between 1e-5% "
                                   "and 1% of the diagonal")};
  }

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
Mesh truth_of(const Surface& surface, double tolerance) {
  return surface.shape ? surface.shape->mesh(tolerance) : surface.mesh;
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

void bind_scan(Arguments& arguments, ScanOptions& options) {
  arguments.group("Scan");
  // Declared first, so that the other options change what it sets, wherever they stand.
  arguments.option(
      "--quality", OptionType<ScanQuality>::placeholder(),
      "start from a grade: s1 is clean and dense, s2 has noise about as wide as its spacing, s3 wider, with "
      "outliers and gaps; the options below change what they name",
      "", "none", [&options](const std::string& text) { options = scan_quality(OptionType<ScanQuality>::read(text)); });
  arguments.fields(options);
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
  arguments.fields(files);
  const GlobalOptions globals = arguments.parse();
  options.check();
  check_fields(files);
  Outputs outputs(globals, {{"SURFACE", files.is_shape() ? "" : files.surface}});
  outputs.plan({"OUT", files.out});
  outputs.plan({"--truth", files.truth}, true);
  const Console console(globals);

  const Surface surface = load_surface(files);
  const RunContext context = console.context();
  const double diagonal = surface.target().diagonal();
  const double tolerance = files.truth_tolerance.resolve({.diagonal = diagonal}, "truth-tolerance");
  if (!(tolerance >= 1e-7 * diagonal && tolerance <= 0.01 * diagonal))
    throw OptionError("truth-tolerance must be between 1e-5% and 1% of the diagonal, not " +
                      files.truth_tolerance.text());
  VirtualScan scan = on_data_of(files.surface, [&] { return virtual_scan(surface.target(), options, context); });
  const PointCloud cloud = chosen_columns(std::move(scan), files, diagonal);

  outputs.stage(files.out, [&](const std::string& path) { write_points(cloud, path, encoding); });
  outputs.stage(files.truth,
                [&](const std::string& path) { write_mesh(truth_of(surface, tolerance), path, encoding); });
  outputs.commit(context);
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
