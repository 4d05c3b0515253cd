// Which format a file has, and the errors of those that have none of ours.

#include <gpsrecon/io/io.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gpsrecon/core/error.h>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "columns.h"
#include "formats.h"
#include "output_file.h"
#include "ply_header.h"
#include "text.h"

namespace gpsrecon {

using namespace internal;
namespace {

using io::InputFile;

enum class Format { ply, xyz, pcd, off, obj, stl, glb, foreign, unknown };

struct Extension {
  std::string_view name;
  Format format;
};
constexpr std::array extensions{
    Extension{"ply", Format::ply}, Extension{"xyz", Format::xyz}, Extension{"txt", Format::xyz},
    Extension{"asc", Format::xyz}, Extension{"csv", Format::xyz}, Extension{"pcd", Format::pcd},
    Extension{"off", Format::off}, Extension{"obj", Format::obj}, Extension{"stl", Format::stl},
    Extension{"glb", Format::glb},
};

// Formats that are met in practice and are not read (though one is written), with what converts them.
struct ForeignFormat {
  std::string_view extension;
  const char* advice;
};
constexpr std::array foreign_formats{
    ForeignFormat{"las", "LAS files are not read; convert with `pdal translate in.las out.ply`"},
    ForeignFormat{"laz", "LAZ files are not read; convert with `pdal translate in.laz out.ply`"},
    ForeignFormat{"copc", "COPC files are not read; convert with `pdal translate in.copc.laz out.ply`"},
    ForeignFormat{"e57",
                  "E57 files are not read; convert with `CloudCompare -O in.e57 -C_EXPORT_FMT PLY -SAVE_CLOUDS`"},
    ForeignFormat{"pts",
                  "PTS files are not read; convert with `CloudCompare -O in.pts -C_EXPORT_FMT PLY -SAVE_CLOUDS`"},
    ForeignFormat{"ptx",
                  "PTX files are not read; convert with `CloudCompare -O in.ptx -C_EXPORT_FMT PLY -SAVE_CLOUDS`"},
    ForeignFormat{"rcp", "RCP files are not read; export PLY or E57 from ReCap"},
    ForeignFormat{"rcs", "RCS files are not read; export PLY or E57 from ReCap"},
    ForeignFormat{"gltf", "glTF files are not read; convert with `assimp export in.gltf out.ply`"},
    ForeignFormat{"glb", "glTF files are not read; convert with `assimp export in.glb out.ply`"},
    ForeignFormat{"dae", "DAE files are not read; convert with `assimp export in.dae out.ply`"},
    ForeignFormat{"3ds", "3DS files are not read; convert with `assimp export in.3ds out.ply`"},
    ForeignFormat{"3mf", "3MF files are not read; convert with `assimp export in.3mf out.ply`"},
    ForeignFormat{"fbx", "FBX files are not read; convert with `assimp export in.fbx out.ply`"},
    ForeignFormat{"gz",
                  "compressed files are not read; unpack with `gunzip`, or use `zcat in.ply.gz | gpsrecon - out.ply`"},
    ForeignFormat{"zip", "archives are not read; unpack with `unzip`"},
};
constexpr const char* supported =
    "expected a file of points (.ply .xyz .txt .asc .csv .pcd) or a mesh (.ply .off .obj .stl)";

std::string extension_of(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension.empty() ? extension : extension.substr(1);
}

const ForeignFormat* foreign_format(const std::string& path) {
  for (const ForeignFormat& format : foreign_formats)
    if (io::same_word(extension_of(path), format.extension)) return &format;
  return nullptr;
}

Format format_of(const std::string& path) {
  if (path == "-") return Format::ply;
  const std::string extension = extension_of(path);
  for (const Extension& e : extensions)
    if (io::same_word(extension, e.name)) return e.format;
  return foreign_format(path) != nullptr ? Format::foreign : Format::unknown;
}

bool is_never_read(Format format) {
  return format == Format::foreign || format == Format::glb;
}

// Files of no known extension may still be PLY files.
Format input_format(const InputFile& file) {
  const Format format = format_of(file.path());
  if (format == Format::unknown && io::is_ply(file)) return Format::ply;
  if (is_never_read(format)) file.fail(foreign_format(file.path())->advice);
  if (format == Format::unknown) file.fail(supported);
  return format;
}

// The whole file. A large file that will not be read anyway is refused by its first bytes; a pipe has no second
// reading.
InputFile open_input(const std::string& path) {
  constexpr std::size_t magic_bytes = 16;
  const Format format = format_of(path);
  std::error_code ignored;
  if ((is_never_read(format) || format == Format::unknown) && std::filesystem::is_regular_file(path, ignored))
    input_format(InputFile(path, magic_bytes));
  return InputFile(path);
}

InputFile require_ply(const std::string& path, const char* what) {
  InputFile file = open_input(path);
  if (input_format(file) != Format::ply) file.fail(std::string("expected a PLY file of ") + what);
  return file;
}

Mesh read_mesh_as(const InputFile& file, Format format) {
  switch (format) {
    case Format::ply:
      return io::read_ply_mesh(file);
    case Format::off:
      return io::read_off(file);
    case Format::obj:
      return io::read_obj(file);
    case Format::stl:
      return io::read_stl(file);
    default:
      file.fail("expected a mesh (.ply .off .obj .stl)");
  }
}

PointCloud vertices_of(Mesh mesh) {
  PointCloud cloud;
  cloud.positions = std::move(mesh.positions);
  cloud.normals = std::move(mesh.normals);
  cloud.colors = std::move(mesh.colors);
  return cloud;
}

// Everything but refined meshes is written as PLY whatever the name; only names that promise something else are
// refused.
void require_ply_name(const std::string& path) {
  const Format format = format_of(path);
  if (format != Format::ply && format != Format::unknown)
    throw OutputError(path + ": expected a name with the extension .ply, which is the format of this output");
}

void require_mesh_name(const std::string& path) {
  switch (format_of(path)) {
    case Format::ply:
    case Format::off:
    case Format::obj:
    case Format::stl:
    case Format::glb:
      return;
    default:
      throw OutputError(path + ": expected a name with the extension .ply, .off, .obj, .stl or .glb");
  }
}

}  // namespace

FileKind probe_file(const std::string& path) {
  constexpr std::size_t header_bytes = 1 << 16;
  InputFile file(path, header_bytes);
  switch (input_format(file)) {
    case Format::ply:
      // A header longer than that is possible; then the whole file is needed to find its end.
      if (file.bytes().size() < file.file_size() && file.bytes().find("end_header") == std::string_view::npos)
        file = InputFile(path);
      return io::probe_ply(file);
    case Format::off:
    case Format::obj:
    case Format::stl:
      return FileKind::mesh;
    default:
      return FileKind::points;
  }
}

PointCloud read_points(const std::string& path) {
  const InputFile file = open_input(path);
  switch (const Format format = input_format(file)) {
    case Format::ply:
      return io::read_ply_points(file);
    case Format::xyz:
      return io::read_xyz(file);
    case Format::pcd:
      return io::read_pcd(file);
    default:
      return vertices_of(read_mesh_as(file, format));
  }
}

Mixture read_mixture(const std::string& path) {
  return io::read_ply_mixture(require_ply(path, "Gaussians"));
}

CovMesh read_covmesh(const std::string& path, bool manifold) {
  return io::read_ply_covmesh(require_ply(path, "Gaussians and faces"), manifold);
}

Mesh read_mesh(const std::string& path) {
  const InputFile file = open_input(path);
  return read_mesh_as(file, input_format(file));
}

void write_points(const PointCloud& cloud, const std::string& path, PlyEncoding encoding) {
  require_ply_name(path);
  io::write_ply(cloud, path, encoding);
}

void write_mixture(const Mixture& mixture, const std::string& path, PlyEncoding encoding) {
  require_ply_name(path);
  io::write_ply(mixture, path, encoding);
}

void write_covmesh(const CovMesh& mesh, const std::string& path, PlyEncoding encoding) {
  require_ply_name(path);
  io::write_ply(mesh, path, encoding);
}

void write_mesh(const Mesh& mesh, const std::string& path, PlyEncoding encoding) {
  require_mesh_name(path);
  switch (format_of(path)) {
    case Format::off:
      return io::write_off(mesh, path);
    case Format::obj:
      return io::write_obj(mesh, path);
    case Format::stl:
      return io::write_stl(mesh, path);
    case Format::glb:
      return io::write_glb(mesh, path);
    default:
      return io::write_ply(mesh, path, encoding);
  }
}

void check_writable(const std::string& path, bool mesh_format) {
  if (mesh_format) require_mesh_name(path);
  if (path == "-") return;
  struct stat status;
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) {
    // Opening a pipe or device has effects of its own.
    if (::access(path.c_str(), W_OK) != 0) throw OutputError(path + ": cannot write: " + std::strerror(errno));
    return;
  }
  const OutputFile trial(path);
}

}  // namespace gpsrecon
