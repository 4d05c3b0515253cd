// Every way to write the same points down as PLY must be read alike. The files are made by an encoder of the test's
// own.

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/io/io.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

#include "support/temporary_folder.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::TemporaryFolder;
using test::write_bytes;

enum class Encoding { ascii, little, big };

struct TypeCase {
  const char* name;
  char kind;  // i, u, f
  int size;
};

constexpr TypeCase all_types[] = {
    {"char", 'i', 1},   {"int8", 'i', 1},   {"uchar", 'u', 1},    {"uint8", 'u', 1},  {"short", 'i', 2},
    {"int16", 'i', 2},  {"ushort", 'u', 2}, {"uint16", 'u', 2},   {"int", 'i', 4},    {"int32", 'i', 4},
    {"uint", 'u', 4},   {"uint32", 'u', 4}, {"longlong", 'i', 8}, {"int64", 'i', 8},  {"ulonglong", 'u', 8},
    {"uint64", 'u', 8}, {"float", 'f', 4},  {"float32", 'f', 4},  {"double", 'f', 8}, {"float64", 'f', 8}};

constexpr TypeCase type_named(std::string_view name) {
  for (const TypeCase& type : all_types)
    if (type.name == name) return type;
  throw "unknown type";
}

// Writes values one after the other in the wanted encoding.
class Encoder {
 public:
  Encoder(Encoding encoding, std::string newline) : encoding_(encoding), newline_(std::move(newline)) {}

  void value(const TypeCase& type, double number) {
    if (encoding_ == Encoding::ascii) {
      char digits[40];
      char* const end = std::to_chars(digits, digits + sizeof(digits), number).ptr;
      bytes_.append(digits, end).append(" ");
      return;
    }
    std::uint64_t bits;
    if (type.kind == 'f')
      bits = type.size == 4 ? std::bit_cast<std::uint32_t>(static_cast<float>(number))
                            : std::bit_cast<std::uint64_t>(number);
    else
      bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(number));
    for (int i = 0; i < type.size; ++i) {
      const int byte = encoding_ == Encoding::little ? i : type.size - 1 - i;
      bytes_ += static_cast<char>(bits >> (8 * byte) & 0xFF);
    }
  }
  void list(const TypeCase& length_type, const TypeCase& type, const std::vector<double>& numbers) {
    value(length_type, static_cast<double>(numbers.size()));
    for (const double number : numbers) value(type, number);
  }
  void end_row() {
    if (encoding_ == Encoding::ascii) bytes_ += newline_;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  Encoding encoding_;
  std::string newline_;
  std::string bytes_;
};

struct Dialect {
  Encoding encoding;
  std::string newline;
  TypeCase type;  // of coordinates, and of the entries of lists if it is not floating
  bool faces_first;
  bool vertex_lists;    // list properties between the others
  bool extra_elements;  // with lists and scalars, before, between and behind
  std::uint64_t seed;   // of the order of properties
};

constexpr std::size_t vertex_count = 7;
constexpr std::size_t face_count = 3;
constexpr int faces[face_count][4] = {{0, 1, 2, 3}, {6, 5, 4, 0}, {3, 5, 1, 2}};

// Small whole numbers, so that every type holds them; negative ones where the type has a sign.
double coordinate(const TypeCase& type, std::size_t vertex, std::size_t axis) {
  const double number = static_cast<double>(10 * vertex + axis + 1);
  if (type.kind == 'u') return number;
  return (axis == 1 ? -1 : 1) * (type.kind == 'f' ? number + 0.375 : number);
}

struct Column {
  std::string name;
  TypeCase type;
  bool is_list = false;
};

std::vector<Column> shuffled_columns(const Dialect& dialect) {
  std::vector<Column> columns{{"x", dialect.type},           {"y", dialect.type},
                              {"z", dialect.type},           {"nx", type_named("float")},
                              {"ny", type_named("double")},  {"nz", type_named("float32")},
                              {"red", type_named("uchar")},  {"green", type_named("uint8")},
                              {"blue", type_named("uchar")}, {"Intensity", type_named("ushort")}};
  if (dialect.vertex_lists) {
    columns.push_back({"first_list", type_named("double"), true});
    columns.push_back({"second_list", type_named("short"), true});
  }
  for (std::size_t i = columns.size() - 1; i > 0; --i)
    std::swap(columns[i], columns[random_bits(dialect.seed, 1, i) % (i + 1)]);
  return columns;
}

double vertex_value(const Dialect& dialect, const std::string& name, std::size_t v) {
  if (name == "x" || name == "y" || name == "z")
    return coordinate(dialect.type, v, static_cast<std::size_t>(name[0] - 'x'));
  if (name == "nx" || name == "ny" || name == "nz")
    return 0.25 * static_cast<double>(v) - static_cast<double>(name[1] - 'x');
  if (name == "red") return static_cast<double>(250 - v);
  if (name == "green") return static_cast<double>(v);
  if (name == "blue") return static_cast<double>(128 + v);
  return 60000.0 + static_cast<double>(v);
}

std::string encode(const Dialect& dialect) {
  const std::string n = dialect.newline;
  const char* const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
  std::string header = "ply" + n + "format " + formats[static_cast<int>(dialect.encoding)] + " 1.0" + n +
                       "comment made by a test" + n + "obj_info element vertex 3" + n + "comment" + n;
  Encoder body(dialect.encoding, n);
  const TypeCase uchar_type = type_named("uchar"), float_type = type_named("float");
  // One byte per index is enough for the corners.
  const TypeCase index_type = dialect.type.kind == 'f' ? type_named("uint") : dialect.type;

  const auto add_extra = [&](const std::string& name) {
    if (!dialect.extra_elements) return;
    header += "element " + name + " 2" + n + "property float x" + n + "property list uchar float weights" + n +
              "property uchar vertex_indices" + n;
    for (std::size_t row = 0; row < 2; ++row) {
      body.value(float_type, 0.5);
      body.list(uchar_type, float_type, std::vector<double>(3 * row, 0.125));
      body.value(uchar_type, 7);
      body.end_row();
    }
  };
  const auto add_vertices = [&] {
    const std::vector<Column> columns = shuffled_columns(dialect);
    header += "element vertex " + std::to_string(vertex_count) + n;
    for (const Column& column : columns)
      header +=
          std::string("property ") + (column.is_list ? "list uchar " : "") + column.type.name + " " + column.name + n;
    for (std::size_t v = 0; v < vertex_count; ++v) {
      for (const Column& column : columns) {
        if (column.is_list)
          body.list(uchar_type, column.type, std::vector<double>(v % 3, 3));
        else
          body.value(column.type, vertex_value(dialect, column.name, v));
      }
      body.end_row();
    }
  };
  const auto add_faces = [&] {
    header += "element face " + std::to_string(face_count) + n + "property uchar flags" + n + "property list " +
              (dialect.type.kind == 'f' ? "uchar" : dialect.type.name) + " " + index_type.name +
              (dialect.seed % 2 == 0 ? " vertex_indices" : " vertex_index") + n + "property list uchar float texcoord" +
              n;
    for (const auto& face : faces) {
      body.value(uchar_type, 1);
      body.list(dialect.type.kind == 'f' ? uchar_type : dialect.type, index_type,
                {double(face[0]), double(face[1]), double(face[2]), double(face[3])});
      body.list(uchar_type, float_type, {0.5, 0.25});
      body.end_row();
    }
  };

  add_extra("camera");
  if (dialect.faces_first) add_faces();
  add_extra("edge");
  add_vertices();
  add_extra("material");
  if (!dialect.faces_first) add_faces();
  add_extra("multi_patch");
  return header + "end_header" + n + body.bytes();
}

void expect_vertices(const Dialect& dialect, const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                     const std::vector<Color>& colors, const std::vector<ScalarColumn>& scalars) {
  ASSERT_EQ(positions.size(), vertex_count);
  ASSERT_EQ(normals.size(), vertex_count);
  ASSERT_EQ(colors.size(), vertex_count);
  ASSERT_EQ(scalars.size(), 1u);
  EXPECT_EQ(scalars[0].name, "Intensity");
  ASSERT_EQ(scalars[0].values.size(), vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      EXPECT_EQ(positions[v][a], coordinate(dialect.type, v, axis));
      EXPECT_EQ(normals[v][a], 0.25 * static_cast<double>(v) - static_cast<double>(axis));
    }
    EXPECT_EQ(colors[v], (Color{static_cast<std::uint8_t>(250 - v), static_cast<std::uint8_t>(v),
                                static_cast<std::uint8_t>(128 + v)}));
    EXPECT_EQ(scalars[0].values[v], 60000.0 + static_cast<double>(v));
  }
}

class PlyDialects : public testing::TestWithParam<TypeCase> {};

TEST_P(PlyDialects, AllAreReadAlike) {
  const TemporaryFolder folder;
  const std::string path = folder / "dialect.ply";
  std::uint64_t seed = 0;
  for (const Encoding encoding : {Encoding::ascii, Encoding::little, Encoding::big})
    for (const char* const newline : {"\n", "\r\n", "\r"})
      for (const bool faces_first : {false, true})
        for (const bool vertex_lists : {false, true})
          for (const bool extra_elements : {false, true}) {
            const Dialect dialect{encoding, newline, GetParam(), faces_first, vertex_lists, extra_elements, ++seed};
            const std::string bytes = encode(dialect);
            SCOPED_TRACE(bytes.substr(0, bytes.find("end_header")));
            write_bytes(path, bytes);
            EXPECT_EQ(probe_file(path), FileKind::mesh);
            const PointCloud cloud = read_points(path);
            expect_vertices(dialect, cloud.positions, cloud.normals, cloud.colors, cloud.scalars);
            const Mesh mesh = read_mesh(path);
            expect_vertices(dialect, mesh.positions, mesh.normals, mesh.colors, mesh.scalars);
            ASSERT_EQ(mesh.faces.size(), face_count);
            for (std::size_t f = 0; f < face_count; ++f)
              EXPECT_TRUE(
                  std::equal(mesh.faces[f].begin(), mesh.faces[f].end(), std::begin(faces[f]), std::end(faces[f])));
            if (HasFailure()) return;
          }
}

INSTANTIATE_TEST_SUITE_P(EveryType, PlyDialects, testing::ValuesIn(all_types),
                         [](const testing::TestParamInfo<TypeCase>& test_case) {
                           return std::string(test_case.param.name);
                         });

// Blocks of rows are converted one after the other; the seams must not show.
TEST(Ply, ManyRows) {
  const TemporaryFolder folder;
  const std::string path = folder / "many.ply";
  PointCloud cloud;
  for (std::size_t i = 0; i < 5000; ++i) {
    const double number = static_cast<double>(i);
    cloud.positions.emplace_back(number, -number, 0.5 * number);
    cloud.colors.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 256), 7});
  }
  write_points(cloud, path);
  const PointCloud read = read_points(path);
  EXPECT_EQ(read.positions, cloud.positions);
  EXPECT_EQ(read.colors, cloud.colors);
}

// Colours of other types than bytes: 0..1 or 0..255 by what is there.
TEST(Ply, FloatColors) {
  const TemporaryFolder folder;
  const std::string path = folder / "colors.ply";
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float "
      "diffuse_red\nproperty float diffuse_green\nproperty float diffuse_blue\nend_header\n";
  write_bytes(path, header + "0 0 0 0 0.5 1\n0 0 0 nan -1 0.2\n");
  EXPECT_EQ(read_points(path).colors, (std::vector<Color>{{0, 128, 255}, {0, 0, 51}}));
  write_bytes(path, header + "0 0 0 0 0.5 1\n0 0 0 300 -1 2\n");
  EXPECT_EQ(read_points(path).colors, (std::vector<Color>{{0, 1, 1}, {255, 0, 2}}));
}

TEST(Ply, SensorsAndIncompleteTriples) {
  const TemporaryFolder folder;
  const std::string path = folder / "sensors.ply";
  write_bytes(path,
              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float sz\nproperty float X\nproperty float Y\n"
              "property float Z\nproperty float sx\nproperty float sy\nproperty float nx\nproperty float weight\n"
              "end_header\n9 1 2 3 7 8 0.5 4\n");
  const PointCloud cloud = read_points(path);
  EXPECT_EQ(cloud.positions, std::vector<Vec3>{Vec3(1, 2, 3)});
  EXPECT_EQ(cloud.sensors, std::vector<Vec3>{Vec3(7, 8, 9)});
  EXPECT_TRUE(cloud.normals.empty());
  EXPECT_TRUE(cloud.weights.empty());
  ASSERT_EQ(cloud.scalars.size(), 2u);
  EXPECT_EQ(cloud.scalars[0].name, "nx");
  EXPECT_EQ(cloud.scalars[1].name, "weight");
}

}  // namespace
}  // namespace gpsrecon
