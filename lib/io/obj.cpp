// Meshes in Wavefront OBJ files: vertices, vertex normals and polygons; everything else is passed over.

#include <algorithm>
#include <array>
#include <cmath>

#include "columns.h"
#include "formats.h"
#include "text.h"
#include "text_writer.h"

namespace gpsrecon::internal::io {
namespace {

// Records of the format that say nothing about the polygons.
constexpr std::array ignored_records{
    "t",          "vt",        "vp",    "l",        "p",        "g",    "o",      "s",   "mg",   "usemtl", "mtllib",
    "usemap",     "maplib",    "bevel", "c_interp", "d_interp", "lod",  "cstype", "deg", "bmat", "step",   "curv",
    "curv2",      "surf",      "parm",  "trim",     "hole",     "scrv", "sp",     "end", "con",  "ctech",  "stech",
    "shadow_obj", "trace_obj", "call",  "csh",      "bsp",      "bzp",  "cdc",    "cdp", "res"};

class ObjReader {
 public:
  explicit ObjReader(const InputFile& file) : file_(file), lines_(file.bytes()) {}

  Mesh read() {
    std::string joined;
    while (lines_.next_filled('#')) read_record(whole_line(joined));
    check_corners();
    if (colors_[0].size() == mesh_.positions.size() && !mesh_.positions.empty()) mesh_.colors = to_colors(colors_);
    set_normals();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { file_.fail_at_line(lines_.number(), message); }

  // A backslash at the end joins the next line.
  std::string_view whole_line(std::string& joined) {
    if (!lines_.line().ends_with('\\')) return lines_.line();
    joined = lines_.line();
    while (joined.ends_with('\\')) {
      joined.back() = ' ';
      if (!lines_.next()) fail("expected the continuation of a line, found the end of the file");
      joined += lines_.line();
    }
    return joined;
  }

  void read_record(std::string_view line) {
    FieldReader fields(line);
    std::string_view keyword;
    fields.next(keyword);
    if (keyword == "v") {
      read_vertex(fields);
    } else if (keyword == "vn") {
      normals_.push_back(read_vector(fields, "a coordinate of the normal"));
    } else if (keyword == "f" || keyword == "fo") {
      read_face(fields);
    } else if (std::find(ignored_records.begin(), ignored_records.end(), keyword) == ignored_records.end()) {
      fail("expected a record of an OBJ file (v, vn, f, ...), found " + quote(line));
    }
  }

  Vec3 read_vector(FieldReader& fields, const std::string& what) const {
    Vec3 vector;
    for (double& number : vector) {
      std::string_view field;
      if (!fields.next(field)) fail("expected " + what + ", found the end of the line");
      if (!parse_number(field, number)) fail("expected " + what + ", found " + quote(field));
    }
    return vector;
  }

  // v x y z [weight], or v x y z red green blue as many scanners write it
  void read_vertex(FieldReader& fields) {
    if (mesh_.positions.size() + 1 >= no_index) fail("expected less than 2^32 - 1 vertices");
    mesh_.positions.push_back(read_vector(fields, "a coordinate"));
    std::array<double, 3> more{};
    std::size_t count = 0;
    for (std::string_view field; fields.next(field); ++count) {
      double number;
      if (!parse_number(field, number)) fail("expected a number, found " + quote(field));
      if (count < 3) more[count] = number;
    }
    if (count < 3) return;
    for (std::size_t channel = 0; channel < 3; ++channel) colors_[channel].push_back(more[channel]);
  }

  void read_face(FieldReader& fields) {
    const std::size_t begin = mesh_.faces.corners.size();
    for (std::string_view field; fields.next(field);) read_corner(field);
    const std::size_t size = mesh_.faces.corners.size() - begin;
    if (size < 3) fail("expected a face of at least 3 corners, found " + std::to_string(size));
    mesh_.faces.offsets.push_back(static_cast<std::uint32_t>(mesh_.faces.corners.size()));
  }

  // vertex, vertex/texture, vertex//normal or vertex/texture/normal
  void read_corner(std::string_view field) {
    const std::size_t slash = std::min(field.find('/'), field.size());
    const std::size_t second = std::min(field.find('/', slash + 1), field.size());
    const Index vertex = read_index(field.substr(0, slash), mesh_.positions.size(), "vertex", field);
    Index normal = no_index;
    if (second + 1 < field.size()) normal = read_index(field.substr(second + 1), normals_.size(), "normal", field);
    mesh_.faces.corners.push_back(vertex);
    corner_normals_.push_back(normal);
  }

  // Counted from one, or backwards from the end as it is now.
  Index read_index(std::string_view text, std::size_t count, const char* what, std::string_view field) const {
    std::int64_t index;
    if (!parse_integer(text, index) || index == 0 || index >= no_index)
      fail(std::string("expected the index of a ") + what + ", found " + quote(field));
    if (index < 0) index += static_cast<std::int64_t>(count) + 1;
    if (index < 1) fail("expected an index of the " + std::to_string(count) + " so far, found " + quote(field));
    return static_cast<Index>(index - 1);
  }

  // Faces may come before their vertices, so that this can only be told at the end.
  void check_corners() const {
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f)
      for (const Index corner : mesh_.faces[f])
        if (corner >= mesh_.positions.size())
          file_.fail("face " + std::to_string(f) + ": expected a vertex index of at most " +
                     std::to_string(mesh_.positions.size()) + ", found " + std::to_string(corner + 1));
  }

  // Normals belong to corners in this format and to vertices in ours: they are kept if all corners of every vertex
  // agree, and given up at the first crease.
  void set_normals() {
    if (normals_.empty()) return;
    std::vector<Index> normal_of(mesh_.positions.size(), no_index);
    for (std::size_t k = 0; k < corner_normals_.size(); ++k) {
      Index& normal = normal_of[mesh_.faces.corners[k]];
      if (normal == no_index) normal = corner_normals_[k];
      if (normal != corner_normals_[k]) return;
    }
    for (const Index normal : normal_of)
      if (normal >= normals_.size()) return;
    for (const Index normal : normal_of) mesh_.normals.push_back(normals_[normal]);
  }

  const InputFile& file_;
  LineReader lines_;
  Mesh mesh_;
  std::array<std::vector<double>, 3> colors_;
  std::vector<Vec3> normals_;
  std::vector<Index> corner_normals_;
};

}  // namespace

Mesh read_obj(const InputFile& file) {
  return ObjReader(file).read();
}

void write_obj(const Mesh& mesh, const std::string& path) {
  TextWriter out(path);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3 world = mesh.frame.to_world(mesh.positions[i]);
    out.text("v ").number(world.x()).number(world.y()).number(world.z(), mesh.colors.empty() ? '\n' : ' ');
    // Four decimals tell 256 levels apart.
    for (std::size_t channel = 0; channel < 3 && !mesh.colors.empty(); ++channel)
      out.number(std::round(mesh.colors[i][channel] / 255.0 * 1e4) / 1e4, channel < 2 ? ' ' : '\n');
  }
  for (const Vec3& n : mesh.normals) out.text("vn ").number(n.x()).number(n.y()).number(n.z(), '\n');
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    out.text("f");
    for (const Index corner : mesh.faces[f]) {
      const std::uint64_t number = std::uint64_t{corner} + 1;
      out.text(" ");
      if (mesh.normals.empty())
        out.number(number);
      else
        out.number(number, '/').text("/").number(number);
    }
    out.text("\n");
  }
  out.commit();
}

}  // namespace gpsrecon::internal::io
