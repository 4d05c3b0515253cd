// Binary glTF, read back by a reader that goes by the specification alone.

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/io/io.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "small_files.h"

namespace gpsrecon {

using namespace internal;
namespace {

using Json = nlohmann::json;
using test::TemporaryFolder;
using testing::HasSubstr;

std::uint32_t word_at(const std::string& bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes.at(offset + i))) << 8 * i;
  return value;
}

/// A GLB file taken apart: section numbers are those of the glTF 2.0 specification.
class Glb {
 public:
  explicit Glb(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    // 4.4.2: header
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(word_at(bytes, 4), 2u);
    EXPECT_EQ(word_at(bytes, 8), bytes.size());
    // 4.4.3: chunks, JSON first, each of a multiple of four bytes
    const std::uint32_t json_size = word_at(bytes, 12);
    EXPECT_EQ(json_size % 4, 0u);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    json = Json::parse(bytes.substr(20, json_size));
    const std::size_t binary = 20 + json_size;
    if (binary == bytes.size()) return;
    EXPECT_EQ(binary % 4, 0u);
    EXPECT_EQ(word_at(bytes, binary) % 4, 0u);
    EXPECT_EQ(bytes.substr(binary + 4, 4), std::string("BIN\0", 4));
    EXPECT_EQ(binary + 8 + word_at(bytes, binary), bytes.size());
    buffer_ = bytes.substr(binary + 8);
    EXPECT_EQ(json["buffers"].size(), 1u);
    const std::size_t length = json["buffers"][0]["byteLength"];
    EXPECT_LE(length, buffer_.size());
    EXPECT_LT(buffer_.size() - length, 4u);
    for (const Json& view : json["bufferViews"])
      EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(), length);
  }

  const Json& primitive() const { return json["meshes"][0]["primitives"][0]; }
  bool has(const std::string& attribute) const { return primitive()["attributes"].contains(attribute); }
  std::size_t accessor_of(const std::string& attribute) const { return primitive()["attributes"][attribute]; }

  /// Rows of an accessor, as doubles, with all its numbers.
  std::vector<std::vector<double>> rows(std::size_t accessor) const {
    const Json& a = json["accessors"][accessor];
    const Json& view = json["bufferViews"][a["bufferView"].get<std::size_t>()];
    const std::string type = a["type"];
    const std::size_t width = type == "SCALAR" ? 1 : static_cast<std::size_t>(type.back() - '0');
    const int component = a["componentType"];
    const std::size_t size = component == 5126 || component == 5125 ? 4 : component == 5123 ? 2 : 1;
    const std::size_t offset = view["byteOffset"].get<std::size_t>() + a.value("byteOffset", std::size_t{0});
    EXPECT_FALSE(view.contains("byteStride"));
    // 3.6.2.4: alignment of elements to their component, and of vertex attributes to four bytes
    EXPECT_EQ(offset % size, 0u);
    if (view["target"] == 34962) {
      EXPECT_EQ(offset % 4, 0u);
      EXPECT_EQ(width * size % 4, 0u);
    }
    const std::size_t count = a["count"];
    EXPECT_GT(count, 0u);
    EXPECT_EQ(count * width * size, view["byteLength"].get<std::size_t>());
    std::vector<std::vector<double>> result(count, std::vector<double>(width));
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < width; ++k) {
        const std::size_t at = offset + (i * width + k) * size;
        if (component == 5126) {
          const std::uint32_t bits = word_at(buffer_, at);
          float value;
          std::memcpy(&value, &bits, 4);
          result[i][k] = static_cast<double>(value);
        } else if (component == 5125) {
          result[i][k] = word_at(buffer_, at);
        } else if (component == 5123) {
          result[i][k] = static_cast<unsigned char>(buffer_[at]) + 256 * static_cast<unsigned char>(buffer_[at + 1]);
          if (a.value("normalized", false)) result[i][k] /= 65535;
        } else {
          ADD_FAILURE() << "component type " << component;
        }
      }
    return result;
  }

  std::vector<Vec3> vectors(const std::string& attribute) const {
    std::vector<Vec3> result;
    for (const auto& row : rows(accessor_of(attribute))) result.emplace_back(row[0], row[1], row[2]);
    return result;
  }

  /// Positions with the transform of the node.
  std::vector<Vec3> world_positions() const {
    const std::size_t root = json["scenes"][json["scene"].get<std::size_t>()]["nodes"][0];
    const Json& node = json["nodes"][root];
    EXPECT_EQ(node["mesh"], 0);
    Vec3 translation = Vec3::Zero();
    if (node.contains("translation"))
      for (int k = 0; k < 3; ++k) translation[k] = node["translation"][static_cast<std::size_t>(k)];
    std::vector<Vec3> positions = vectors("POSITION");
    for (Vec3& p : positions) p += translation;
    return positions;
  }

  std::vector<std::array<Index, 3>> triangles() const {
    std::vector<std::array<Index, 3>> result;
    const auto corners = rows(primitive()["indices"]);
    EXPECT_EQ(corners.size() % 3, 0u);
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
      result.push_back({static_cast<Index>(corners[i][0]), static_cast<Index>(corners[i + 1][0]),
                        static_cast<Index>(corners[i + 2][0])});
    return result;
  }

  Json json;

 private:
  std::string buffer_;
};

/// A quad that is longer one way, a triangle and a hexagon in the plane z = 1, with normals and colours.
Mesh polygons() {
  Mesh mesh;
  mesh.positions = {{0, 0, 1}, {3, 1, 1}, {4, 4, 1}, {1, 3, 1}, {6, 0, 1}, {6, 3, 1}, {8, 2, 1}, {8, 0, 1}, {7, -1, 1}};
  mesh.faces.add(std::array<Index, 4>{0, 1, 2, 3});
  mesh.faces.add(1, 4, 2);
  mesh.faces.add(std::array<Index, 6>{4, 8, 7, 6, 5, 2});
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.normals.push_back(Vec3(0.1 * static_cast<double>(i), 0.3, 1).normalized());
    mesh.colors.push_back({static_cast<std::uint8_t>(10 * i), 255, static_cast<std::uint8_t>(i)});
  }
  return mesh;
}

class GlbFile : public testing::Test {
 protected:
  Glb write(const Mesh& mesh) {
    write_mesh(mesh, path_);
    return Glb(path_);
  }
  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "mesh.glb";
};

TEST_F(GlbFile, HoldsPositionsNormalsAndColors) {
  const Mesh mesh = polygons();
  const Glb file = write(mesh);
  EXPECT_EQ(file.json["asset"]["version"], "2.0");
  EXPECT_EQ(file.primitive()["mode"], 4);
  EXPECT_EQ(file.json["materials"][0]["doubleSided"], true);
  EXPECT_EQ(file.world_positions(), mesh.positions);
  EXPECT_FALSE(file.json["nodes"][0].contains("translation"));
  const std::vector<Vec3> normals = file.vectors("NORMAL");
  ASSERT_EQ(normals.size(), mesh.normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) EXPECT_LT((normals[i] - mesh.normals[i]).norm(), 1e-7);
  const auto colors = file.rows(file.accessor_of("COLOR_0"));
  ASSERT_EQ(colors.size(), mesh.colors.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    ASSERT_EQ(colors[i].size(), 4u);
    EXPECT_EQ(colors[i][3], 1);
    // Back from linear light to the sRGB byte it came from.
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double linear = colors[i][channel];
      const double s = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
      EXPECT_EQ(std::lround(255 * s), mesh.colors[i][channel]);
    }
  }
}

TEST_F(GlbFile, BoundsAreThoseOfTheNumbersInTheFile) {
  Mesh mesh = polygons();
  for (Vec3& p : mesh.positions) p *= 0.1;  // not exact in float
  const Glb file = write(mesh);
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (const Vec3& p : file.vectors("POSITION")) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Json& accessor = file.json["accessors"][file.accessor_of("POSITION")];
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(accessor["min"][k].get<double>(), low[static_cast<int>(k)]);
    EXPECT_EQ(accessor["max"][k].get<double>(), high[static_cast<int>(k)]);
  }
}

TEST_F(GlbFile, SplitsPolygonsIntoTrianglesThatCoverThem) {
  const Mesh mesh = polygons();
  const auto triangles = write(mesh).triangles();
  ASSERT_EQ(triangles.size(), 2u + 1 + 4);
  // The quad along its shorter diagonal, from 1 to 3.
  for (const std::size_t t : {0, 1}) {
    const std::set<Index> corners(triangles[t].begin(), triangles[t].end());
    EXPECT_TRUE(corners.count(1) == 1 && corners.count(3) == 1);
  }
  // All counter-clockwise still, and together of the area of the polygons.
  double area = 0, expected = 0;
  const auto& p = mesh.positions;
  for (const auto& [a, b, c] : triangles) {
    const double twice = (p[b] - p[a]).cross(p[c] - p[a]).z();
    EXPECT_GT(twice, 0);
    area += 0.5 * twice;
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    for (std::size_t k = 0; k < face.size(); ++k)
      expected += 0.5 * p[face[k]].cross(p[face[(k + 1) % face.size()]]).z();
  }
  EXPECT_NEAR(area, expected, 1e-12);
}

TEST_F(GlbFile, FarFromTheOriginTheNodeCarriesThePlace) {
  Mesh mesh = polygons();
  for (Vec3& p : mesh.positions) p = 0.01 * p + Vec3(6e5, 5e6, 300);
  const Glb file = write(mesh);
  EXPECT_TRUE(file.json["nodes"][0].contains("translation"));
  const std::vector<Vec3> positions = file.world_positions();
  for (std::size_t i = 0; i < positions.size(); ++i) EXPECT_LT((positions[i] - mesh.positions[i]).norm(), 1e-8);
  // The same of a mesh in a frame.
  Mesh local = mesh;
  local.frame = {Vec3(6e5, 5e6, 300), -7};
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) local.positions[i] = local.frame.to_local(mesh.positions[i]);
  const std::vector<Vec3> framed = write(local).world_positions();
  for (std::size_t i = 0; i < framed.size(); ++i) EXPECT_LT((framed[i] - mesh.positions[i]).norm(), 1e-8);
}

TEST_F(GlbFile, NormalsAreUnitVectorsWhateverTheyWere) {
  Mesh mesh = polygons();
  mesh.normals[0] = Vec3::Zero();
  mesh.normals[1] = 1e-200 * Vec3(1, 0, 0);
  mesh.normals[2] = Vec3(0, 30, 40);
  mesh.normals[3] = Vec3::Constant(std::nan(""));
  const std::vector<Vec3> normals = write(mesh).vectors("NORMAL");
  for (const Vec3& n : normals) EXPECT_NEAR(n.norm(), 1, 1e-6);
  EXPECT_LT((normals[1] - Vec3(1, 0, 0)).norm(), 1e-6);
  EXPECT_LT((normals[2] - Vec3(0, 0.6, 0.8)).norm(), 1e-6);
}

TEST_F(GlbFile, MeshesWithoutFacesOrVertices) {
  Mesh mesh = polygons();
  mesh.faces = {};
  mesh.normals.clear();
  mesh.colors.clear();
  const Glb points = write(mesh);
  EXPECT_EQ(points.primitive()["mode"], 0);
  EXPECT_FALSE(points.primitive().contains("indices"));
  EXPECT_FALSE(points.has("NORMAL") || points.has("COLOR_0"));
  EXPECT_EQ(points.world_positions(), mesh.positions);
  const Glb empty = write(Mesh{});
  EXPECT_FALSE(empty.json.contains("meshes"));
  EXPECT_FALSE(empty.json.contains("buffers"));
}

TEST_F(GlbFile, RefusesWhatItCannotHoldAndIsNotRead) {
  Mesh mesh = polygons();
  mesh.positions[0].x() = 1e200;
  EXPECT_THROW(write_mesh(mesh, path_), OutputError);
  EXPECT_FALSE(std::filesystem::exists(path_));
  write_mesh(polygons(), path_);
  for (const auto& read :
       {std::function<void()>([&] { read_mesh(path_); }), std::function<void()>([&] { probe_file(path_); })})
    try {
      read();
      ADD_FAILURE() << "was read";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("glTF files are not read"));
    }
  EXPECT_THROW(write_points(PointCloud{}, path_), OutputError);
}

TEST_F(GlbFile, IsTheSameForTheSameMesh) {
  const auto bytes = [this] {
    write_mesh(polygons(), path_);
    std::ifstream file(path_, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  const std::string first = bytes();
  EXPECT_EQ(bytes(), first);
  EXPECT_EQ(first.find("date"), std::string::npos);
}

}  // namespace
}  // namespace gpsrecon
