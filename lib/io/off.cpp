// Meshes in the Object File Format (text).

#include <gpsrecon/core/error.h>

#include "columns.h"
#include "formats.h"
#include "text.h"
#include "text_writer.h"

namespace gpsrecon::internal::io {
namespace {

// What the rows of vertices hold, told by the letters before "OFF".
struct OffHeader {
  bool normals = false;
  bool colors = false;
  std::int64_t vertices = 0;
  std::int64_t faces = 0;
};

class OffReader {
 public:
  explicit OffReader(const InputFile& file) : file_(file), lines_(file.bytes()) {}

  Mesh read() {
    read_header();
    for (std::int64_t v = 0; v < header_.vertices; ++v) read_vertex();
    for (std::int64_t f = 0; f < header_.faces; ++f) read_face();
    if (lines_.next_filled('#')) fail("expected the end of the file, found " + quote(lines_.line()));
    if (header_.colors && !colors_[0].empty()) mesh_.colors = to_colors(colors_);
    return std::move(mesh_);
  }

  void read_header() {
    if (!lines_.next_filled('#')) fail("expected 'OFF', found the end of the file");
    FieldReader fields(lines_.line());
    std::string_view word;
    fields.next(word);
    std::int64_t first_count;
    // The keyword may be missing, and some files have no blank behind it.
    if (!parse_integer(word, first_count)) {
      const std::size_t keyword = word.find("OFF");
      const std::string_view letters = word.substr(0, keyword);
      if (keyword == std::string_view::npos || letters.find_first_not_of("STCN4n") != std::string_view::npos)
        fail("expected 'OFF', found " + quote(word));
      if (letters.find_first_of("4n") != std::string_view::npos)
        fail("expected three coordinates per vertex (OFF, NOFF, COFF), found " + quote(word));
      header_.normals = letters.find('N') != std::string_view::npos;
      header_.colors = letters.find('C') != std::string_view::npos;
      fields =
          FieldReader(lines_.line().substr(static_cast<std::size_t>(word.data() - lines_.line().data()) + keyword + 3));
    } else {
      fields = FieldReader(lines_.line());
    }
    header_.vertices = read_count(fields, "number of vertices");
    header_.faces = read_count(fields, "number of faces");
    // A coordinate takes at least a digit and a separator, a face at least its length and three corners.
    const auto available = static_cast<std::int64_t>(lines_.remaining()) + 1;
    if (header_.vertices > available / 6 || header_.faces > available / 8)
      fail("expected " + std::to_string(header_.vertices) + " vertices and " + std::to_string(header_.faces) +
           " faces, found a file that is too short for them");
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { file_.fail_at_line(lines_.number(), message); }

  std::int64_t read_count(FieldReader& fields, const std::string& what) {
    std::string_view field;
    while (!fields.next(field)) {
      if (!lines_.next_filled('#')) fail("expected the " + what + ", found the end of the file");
      fields = FieldReader(lines_.line());
    }
    std::int64_t count;
    if (field == "BINARY") fail("expected an OFF file in text form; binary ones are not read, convert with MeshLab");
    if (!parse_integer(field, count) || count < 0 || count >= no_index)
      fail("expected the " + what + ", found " + quote(field));
    return count;
  }

  double read_number(FieldReader& fields, const std::string& what) const {
    std::string_view field;
    double value = 0;
    if (!fields.next(field)) fail("expected " + what + ", found the end of the line");
    if (!parse_number(field, value)) fail("expected " + what + ", found " + quote(field));
    return value;
  }

  Vec3 read_vector(FieldReader& fields, const std::string& what) const {
    const double x = read_number(fields, what), y = read_number(fields, what);
    return {x, y, read_number(fields, what)};
  }

  void read_vertex() {
    const std::string vertex = "vertex " + std::to_string(mesh_.positions.size());
    if (!lines_.next_filled('#'))
      fail("expected " + vertex + " (of " + std::to_string(header_.vertices) + "), found the end of the file");
    FieldReader fields(lines_.line());
    mesh_.positions.push_back(read_vector(fields, "a coordinate"));
    if (header_.normals) mesh_.normals.push_back(read_vector(fields, "a coordinate of the normal"));
    if (header_.colors) {
      const Vec3 color = read_vector(fields, "a colour (red, green, blue)");
      for (int channel = 0; channel < 3; ++channel)
        colors_[static_cast<std::size_t>(channel)].push_back(color[channel]);
    }
  }

  void read_face() {
    const std::string face = "face " + std::to_string(mesh_.faces.size());
    if (!lines_.next_filled('#'))
      fail("expected " + face + " (of " + std::to_string(header_.faces) + "), found the end of the file");
    FieldReader fields(lines_.line());
    std::string_view field;
    fields.next(field);
    std::int64_t size;
    if (!parse_integer(field, size) || size < 3) fail("expected a face of at least 3 corners, found " + quote(field));
    for (std::int64_t k = 0; k < size; ++k) {
      if (!fields.next(field = {})) fail("expected " + std::to_string(size) + " corners, found " + std::to_string(k));
      std::int64_t corner;
      if (!parse_integer(field, corner) || corner < 0 || corner >= header_.vertices)
        fail("expected a vertex index below " + std::to_string(header_.vertices) + ", found " + quote(field));
      mesh_.faces.corners.push_back(static_cast<Index>(corner));
    }
    mesh_.faces.offsets.push_back(static_cast<std::uint32_t>(mesh_.faces.corners.size()));
  }

  const InputFile& file_;
  LineReader lines_;
  OffHeader header_;
  Mesh mesh_;
  std::array<std::vector<double>, 3> colors_;
};

}  // namespace

Mesh read_off(const InputFile& file) {
  return OffReader(file).read();
}

void write_off(const Mesh& mesh, const std::string& path) {
  TextWriter out(path);
  out.text(mesh.colors.empty() ? "OFF\n" : "COFF\n")
      .number(mesh.positions.size())
      .number(mesh.faces.size())
      .text("0\n");
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3 world = mesh.frame.to_world(mesh.positions[i]);
    out.number(world.x()).number(world.y()).number(world.z(), mesh.colors.empty() ? '\n' : ' ');
    if (mesh.colors.empty()) continue;
    for (const std::uint8_t channel : mesh.colors[i]) out.number(channel);
    out.text("255\n");
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const std::span<const Index> face = mesh.faces[f];
    out.number(face.size(), face.empty() ? '\n' : ' ');
    for (std::size_t k = 0; k < face.size(); ++k) out.number(face[k], k + 1 < face.size() ? ' ' : '\n');
  }
  out.commit();
}

}  // namespace gpsrecon::internal::io
