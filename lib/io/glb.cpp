// Meshes as glTF 2.0 in its binary form (GLB): one node with one mesh of one primitive.

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/version.h>
#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formats.h"
#include "output_file.h"
#include "precision.h"

namespace gpsrecon::internal::io {
namespace {

using Json = nlohmann::ordered_json;
using Vec3f = Eigen::Vector3f;

// Constants of the format, by the names it gives them.
constexpr std::uint32_t magic = 0x46546C67, container_version = 2, json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;
constexpr int unsigned_short_type = 5123, unsigned_int_type = 5125, float_type = 5126;
constexpr int array_buffer = 34962, element_array_buffer = 34963;
constexpr int points_mode = 0, triangles_mode = 4;

// What the file holds, in its types.
struct Content {
  Vec3 translation = Vec3::Zero();  // of the node, where the positions alone would lose digits
  std::vector<Vec3f> positions, normals;
  std::vector<std::array<std::uint16_t, 4>> colors;
  std::vector<std::uint32_t> corners;  // of triangles
};

// Positions, moved to the middle where that is needed to keep them apart in float.
void set_positions(const Mesh& mesh, const std::string& path, Content& content) {
  const std::vector<Vec3> world = in_frame(mesh.positions, mesh.frame, Frame{});
  if (!float_suffices(world)) {
    const Box3 box = bounding_box(world);
    content.translation = box.min() + 0.5 * box.diagonal();
  }
  for (const Vec3& p : world) {
    content.positions.push_back((p - content.translation).cast<float>());
    if (!content.positions.back().allFinite())
      throw OutputError(path + ": the coordinates are beyond the range of `float`, which is all that glTF holds");
  }
}

// The format wants unit vectors; where there is no normal any of them will do.
void set_normals(const Mesh& mesh, Content& content) {
  for (const Vec3& n : mesh.normals) {
    const Vec3 unit = n.stableNormalized();
    const bool is_unit = std::abs(unit.squaredNorm() - 1) < 1e-6;
    content.normals.push_back((is_unit ? unit : Vec3(Vec3::UnitZ())).cast<float>());
  }
}

// Colours of vertices are linear in this format, and those of points are sRGB. Bytes would not tell dark ones apart.
void set_colors(const Mesh& mesh, Content& content) {
  std::array<std::uint16_t, 256> linear;
  for (std::size_t level = 0; level < linear.size(); ++level) {
    const double s = static_cast<double>(level) / 255;
    const double intensity = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    linear[level] = static_cast<std::uint16_t>(std::lround(intensity * 65535));
  }
  for (const Color& c : mesh.colors) content.colors.push_back({linear[c[0]], linear[c[1]], linear[c[2]], 65535});
}

// Quads are split along their shorter diagonal, larger polygons into fans.
void set_corners(const Mesh& mesh, Content& content) {
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const std::span<const Index> face = mesh.faces[f];
    const auto squared_length = [&](std::size_t i, std::size_t j) {
      return (mesh.positions[face[i]] - mesh.positions[face[j]]).squaredNorm();
    };
    const std::size_t apex = face.size() == 4 && squared_length(1, 3) < squared_length(0, 2) ? 1 : 0;
    for (std::size_t k = 2; k < face.size(); ++k)
      for (const std::size_t corner : {std::size_t{0}, k - 1, k})
        content.corners.push_back(face[(apex + corner) % face.size()]);
  }
}

Json box_of(const std::vector<Vec3f>& positions) {
  Eigen::AlignedBox3f box;
  for (const Vec3f& p : positions) box.extend(p);
  const Vec3f &low = box.min(), &high = box.max();
  return {{"min", {low.x(), low.y(), low.z()}}, {"max", {high.x(), high.y(), high.z()}}};
}

// The part that says what the bytes mean. All element sizes are multiples of four, and so all offsets.
class Description {
 public:
  explicit Description(const Content& content) {
    Json primitive = {{"attributes", Json::object()}, {"mode", points_mode}, {"material", 0}};
    Json& attributes = primitive["attributes"];
    attributes["POSITION"] = add("VEC3", float_type, content.positions, array_buffer);
    accessors_.back().update(box_of(content.positions));
    if (!content.normals.empty()) attributes["NORMAL"] = add("VEC3", float_type, content.normals, array_buffer);
    if (!content.colors.empty()) {
      attributes["COLOR_0"] = add("VEC4", unsigned_short_type, content.colors, array_buffer);
      accessors_.back()["normalized"] = true;
    }
    if (!content.corners.empty()) {
      primitive["mode"] = triangles_mode;
      primitive["indices"] = add("SCALAR", unsigned_int_type, content.corners, element_array_buffer);
    }
    meshes_.push_back({{"primitives", {primitive}}});
    node_["mesh"] = 0;
    if (!content.translation.isZero(0))
      node_["translation"] = {content.translation.x(), content.translation.y(), content.translation.z()};
  }

  std::uint64_t bytes() const { return bytes_; }

  Json json() const {
    const Json surface = {{"metallicFactor", 0}, {"roughnessFactor", 0.7}};
    return {{"asset", {{"version", "2.0"}, {"generator", std::string("gpsrecon ") + version}}},
            {"scene", 0},
            {"scenes", {{{"nodes", {0}}}}},
            {"nodes", {node_}},
            {"meshes", meshes_},
            {"materials", {{{"pbrMetallicRoughness", surface}, {"doubleSided", true}}}},
            {"accessors", accessors_},
            {"bufferViews", views_},
            {"buffers", {{{"byteLength", bytes_}}}}};
  }

 private:
  template <class T>
  std::size_t add(const char* type, int component_type, const std::vector<T>& values, int target) {
    const std::uint64_t size = values.size() * sizeof(T);
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_}, {"byteLength", size}, {"target", target}});
    accessors_.push_back({{"bufferView", views_.size() - 1},
                          {"componentType", component_type},
                          {"count", values.size()},
                          {"type", type}});
    bytes_ += size;
    return accessors_.size() - 1;
  }

  std::uint64_t bytes_ = 0;
  Json node_ = Json::object(), meshes_ = Json::array(), accessors_ = Json::array(), views_ = Json::array();
};

// Little-endian numbers, whatever the machine.
class ByteWriter {
 public:
  explicit ByteWriter(const std::string& path) : file_(path) {}

  ByteWriter& text(const std::string& characters) {
    bytes_ += characters;
    return *this;
  }
  ByteWriter& number(std::uint16_t value) { return append(value, 2); }
  ByteWriter& number(std::uint32_t value) { return append(value, 4); }
  ByteWriter& number(float value) { return append(std::bit_cast<std::uint32_t>(value), 4); }

  void commit() {
    flush();
    file_.commit();
  }

 private:
  ByteWriter& append(std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) bytes_ += static_cast<char>(value >> 8 * i & 0xFF);
    if (bytes_.size() >= block_size) flush();
    return *this;
  }
  void flush() {
    file_.write(bytes_);
    bytes_.clear();
  }

  static constexpr std::size_t block_size = 1 << 16;
  OutputFile file_;
  std::string bytes_;
};

// A file may be empty of vertices, an accessor may not.
Json empty_scene() {
  return {{"asset", {{"version", "2.0"}, {"generator", std::string("gpsrecon ") + version}}},
          {"scene", 0},
          {"scenes", {{{"name", "empty"}}}}};
}

}  // namespace

void write_glb(const Mesh& mesh, const std::string& path) {
  Content content;
  std::string json = empty_scene().dump();
  std::uint64_t binary_bytes = 0;
  if (!mesh.positions.empty()) {
    set_positions(mesh, path, content);
    set_normals(mesh, content);
    set_colors(mesh, content);
    set_corners(mesh, content);
    const Description description(content);
    json = description.json().dump();
    binary_bytes = description.bytes();
  }
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::uint64_t total = 12 + 8 + json.size() + (binary_bytes > 0 ? 8 + binary_bytes : 0);
  if (total > 0xFFFFFFFFu) throw OutputError(path + ": a binary glTF file holds less than 4 GiB");

  ByteWriter out(path);
  out.number(magic).number(container_version).number(static_cast<std::uint32_t>(total));
  out.number(static_cast<std::uint32_t>(json.size())).number(json_chunk).text(json);
  if (binary_bytes > 0) out.number(static_cast<std::uint32_t>(binary_bytes)).number(binary_chunk);
  for (const std::vector<Vec3f>* vectors : {&content.positions, &content.normals})
    for (const Vec3f& v : *vectors)
      for (const float number : v) out.number(number);
  for (const auto& color : content.colors)
    for (const std::uint16_t channel : color) out.number(channel);
  for (const std::uint32_t corner : content.corners) out.number(corner);
  out.commit();
}

}  // namespace gpsrecon::internal::io
