// Triangles in STL files, binary or text.

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/version.h>
#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cstring>
#include <unordered_map>

#include "formats.h"
#include "output_file.h"
#include "text.h"

namespace gpsrecon::internal::io {
namespace {

constexpr std::size_t header_size = 80;
constexpr std::size_t triangle_size = 12 * sizeof(float) + 2;

// Gives equal corners one vertex, in the order in which they first appear.
class Welder {
 public:
  explicit Welder(Mesh& mesh) : mesh_(mesh) {}

  Index vertex(const Vec3& position) {
    // The sum makes -0 a plain 0; bits, unlike values, also compare where a coordinate is not a number.
    const Key key{std::bit_cast<std::uint64_t>(position.x() + 0.0), std::bit_cast<std::uint64_t>(position.y() + 0.0),
                  std::bit_cast<std::uint64_t>(position.z() + 0.0)};
    const auto [entry, is_new] = index_of_.try_emplace(key, static_cast<Index>(mesh_.positions.size()));
    if (is_new) mesh_.positions.push_back(position);
    return entry->second;
  }

 private:
  using Key = std::array<std::uint64_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t h = 0;
      for (const std::uint64_t word : key) {
        h = (h ^ word) * 0x9E3779B97F4A7C15ull;
        h ^= h >> 32;
      }
      return static_cast<std::size_t>(h);
    }
  };

  Mesh& mesh_;
  std::unordered_map<Key, Index, Hash> index_of_;
};

std::uint32_t load_little_endian(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

void append_little_endian(std::string& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 0xFF);
}

Mesh read_binary(const InputFile& file) {
  Mesh mesh;
  Welder welder(mesh);
  const std::string_view bytes = file.bytes();
  const std::size_t triangles = load_little_endian(bytes.data() + header_size);
  mesh.faces.reserve(triangles, 3 * triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    const char* const corner = bytes.data() + header_size + 4 + t * triangle_size + 3 * sizeof(float);
    std::array<Index, 3> face;
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3 position;
      for (std::size_t axis = 0; axis < 3; ++axis)
        position[static_cast<Eigen::Index>(axis)] =
            std::bit_cast<float>(load_little_endian(corner + (3 * k + axis) * sizeof(float)));
      face[k] = welder.vertex(position);
    }
    mesh.faces.add(face);
  }
  return mesh;
}

// solid [name] { facet normal a b c  outer loop  3 vertex x y z  endloop  endfacet } endsolid [name]
class TextReader {
 public:
  explicit TextReader(const InputFile& file) : file_(file), lines_(file.bytes()), welder_(mesh_) {}

  Mesh read() {
    while (lines_.next_filled()) {
      expect({"solid"});
      while (true) {
        next_line("'facet' or 'endsolid'");
        if (starts_with({"endsolid"})) break;
        read_facet();
      }
    }
    return std::move(mesh_);
  }

 private:
  using Words = std::initializer_list<std::string_view>;

  [[noreturn]] void fail(const std::string& message) const { file_.fail_at_line(lines_.number(), message); }

  void next_line(const std::string& expected) {
    if (!lines_.next_filled()) fail("expected " + expected + ", found the end of the file");
  }

  // Compares the first words of the current line.
  bool starts_with(Words words) {
    fields_ = FieldReader(lines_.line());
    for (const std::string_view word : words) {
      std::string_view field;
      if (!fields_.next(field) || !same_word(field, word)) return false;
    }
    return true;
  }

  void expect(Words words) {
    if (starts_with(words)) return;
    std::string expected;
    for (const std::string_view word : words) expected.append(expected.empty() ? "" : " ").append(word);
    fail("expected '" + expected + "', found " + quote(lines_.line()));
  }

  void read_facet() {
    expect({"facet"});
    next_line("'outer loop'");
    expect({"outer", "loop"});
    std::array<Index, 3> face;
    for (Index& corner : face) {
      next_line("'vertex'");
      expect({"vertex"});
      Vec3 position;
      for (double& number : position) {
        std::string_view field;
        if (!fields_.next(field) || !parse_number(field, number))
          fail("expected three coordinates, found " + quote(lines_.line()));
      }
      corner = welder_.vertex(position);
    }
    next_line("'endloop'");
    expect({"endloop"});
    next_line("'endfacet'");
    expect({"endfacet"});
    mesh_.faces.add(face);
  }

  const InputFile& file_;
  LineReader lines_;
  FieldReader fields_{""};
  Mesh mesh_;
  Welder welder_;
};

}  // namespace

// Binary files may begin with "solid" too; what tells them apart is that their size follows from their count.
Mesh read_stl(const InputFile& file) {
  const std::string_view bytes = file.bytes();
  const std::size_t triangles = bytes.size() >= header_size + 4 ? load_little_endian(bytes.data() + header_size) : 0;
  const std::size_t expected_size = header_size + 4 + triangles * triangle_size;
  if (bytes.size() == expected_size) return read_binary(file);
  const std::size_t text = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  if (same_word(bytes.substr(text, 5), "solid")) return TextReader(file).read();
  if (bytes.size() < header_size + 4)
    file.fail_at_byte(bytes.size(),
                      "expected the header of an STL file (84 bytes, or 'solid'), found the end of the file");
  file.fail_at_byte(header_size, "expected the number of triangles of a file of " + std::to_string(bytes.size()) +
                                     " bytes, found " + std::to_string(triangles) + ", which take " +
                                     std::to_string(expected_size) + " bytes");
}

void write_stl(const Mesh& mesh, const std::string& path) {
  std::uint64_t triangles = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) triangles += std::max<std::size_t>(mesh.faces[f].size(), 2) - 2;
  if (triangles > 0xFFFFFFFFu) throw OutputError(path + ": an STL file holds less than 2^32 triangles");
  OutputFile out(path);
  std::string bytes = std::string("gpsrecon ") + version;
  bytes.resize(header_size, ' ');
  append_little_endian(bytes, static_cast<std::uint32_t>(triangles));
  out.write(bytes);
  const auto rounded = [&mesh](Index v) { return mesh.frame.to_world(mesh.positions[v]).cast<float>().eval(); };
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for_each_triangle(mesh.faces[f], [&](Index i, Index j, Index k) {
      const Eigen::Vector3f a = rounded(i), b = rounded(j), c = rounded(k);
      // Zero where there is no area.
      const Eigen::Vector3f normal =
          area_vector(a.cast<double>(), b.cast<double>(), c.cast<double>()).normalized().cast<float>();
      bytes.clear();
      for (const Eigen::Vector3f* v : {&normal, &a, &b, &c})
        for (const float number : *v) append_little_endian(bytes, std::bit_cast<std::uint32_t>(number));
      bytes.append(2, '\0');
      out.write(bytes);
    });
  }
  out.commit();
}

}  // namespace gpsrecon::internal::io
