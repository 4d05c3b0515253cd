// Colours, scalars and labels in files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "small_files.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::read_bytes;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void expect_same(const std::vector<ScalarColumn>& a, const std::vector<ScalarColumn>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t c = 0; c < a.size(); ++c) {
    EXPECT_EQ(a[c].name, b[c].name);
    EXPECT_EQ(a[c].kind, b[c].kind);
    ASSERT_EQ(a[c].values.size(), b[c].values.size());
    EXPECT_EQ(std::memcmp(a[c].values.data(), b[c].values.data(), a[c].values.size() * sizeof(double)), 0) << a[c].name;
  }
}

/// Six Gaussians with a colour and columns whose names collide with those of Gaussians, of colours and of each other.
Mixture colorful_mixture(bool with_normals) {
  Mixture mixture = test::random_mixture(6, Frame{Vec3(3, -2, 100), 4}, with_normals, 7);
  for (std::uint8_t s = 0; s < 6; ++s) mixture.colors.push_back({s, 255, static_cast<std::uint8_t>(255 - s)});
  mixture.scalars = {{"intensity", {0.1, -1e-300, 3e38, nan, 1. / 3, 0}},
                     {"zone", {1, 2, nan, -4, 5, 4e9}, ScalarKind::label},
                     {"weight", {1, 2, 3, 4, 5, 6}},
                     {"nx", {1, 2, 3, 4, 5, 6}},
                     {"red", {1, 2, 3, 4, 5, 6}, ScalarKind::label},
                     {"gps time", {1, 2, 3, 4, 5, 6}},
                     {"gps_time", {6, 5, 4, 3, 2, 1}},
                     {"class", {6, 5, 4, 3, 2, 1}}};
  return mixture;
}

TEST(Attributes, OfMixturesComeBackAsStored) {
  const TemporaryFolder folder;
  const std::string path = folder / "m.ply";
  for (const bool with_normals : {false, true})
    for (const PlyEncoding encoding : {PlyEncoding::binary, PlyEncoding::ascii}) {
      const Mixture mixture = colorful_mixture(with_normals), stored = as_stored(mixture);
      write_mixture(mixture, path, encoding);
      EXPECT_EQ(probe_file(path), FileKind::mixture);
      const Mixture read = read_mixture(path);
      EXPECT_EQ(read.colors, mixture.colors);
      expect_same(read.scalars, stored.scalars);
      std::vector<std::string> names;
      for (const ScalarColumn& column : read.scalars) names.push_back(column.name);
      EXPECT_THAT(names, ElementsAre("intensity", "zone", "weight_", "nx", "red_", "gps_time", "gps_time_", "class"));
      // What is stored once is stored the same again.
      expect_same(as_stored(stored).scalars, stored.scalars);

      write_covmesh({mixture, test::octahedron().faces}, path, encoding);
      const CovMesh mesh = read_covmesh(path);
      EXPECT_EQ(mesh.vertices.colors, mixture.colors);
      expect_same(mesh.vertices.scalars, stored.scalars);
    }
}

TEST(Attributes, AMixtureWithoutThemHasNoTraceOfThem) {
  const TemporaryFolder folder;
  write_mixture(test::random_mixture(3, {}, false), folder / "m.ply");
  EXPECT_THAT(read_bytes(folder / "m.ply"), Not(HasSubstr("labels")));
  EXPECT_TRUE(read_mixture(folder / "m.ply").scalars.empty());
}

TEST(Attributes, OfMeshesAreAsWideAsTheyNeedToBe) {
  const TemporaryFolder folder;
  Mesh mesh = test::octahedron();
  mesh.scalars = {{"segment", {1, -2, 3, 4, 5, 16777217}, ScalarKind::label},
                  {"label", {1, 2, nan, 4, 5, 6}, ScalarKind::label},
                  {"intensity", {0.1, 0.2, 0.3, nan, 0.5, 0.6}},
                  {"gps_time", {1e9 + 0.1, 1e9 + 0.2, 1e9 + 0.3, 1e9 + 0.4, 1e9 + 0.5, 1e9 + 0.6}}};
  write_mesh(mesh, folder / "m.ply");
  const std::string bytes = read_bytes(folder / "m.ply");
  for (const char* const property : {"int segment", "float label", "float intensity", "double gps_time"})
    EXPECT_THAT(bytes, HasSubstr(std::string("property ") + property + "\n"));
  const Mesh read = read_mesh(folder / "m.ply");
  EXPECT_EQ(read.scalars[0].values, mesh.scalars[0].values);
  EXPECT_EQ(read.scalars[3].values, mesh.scalars[3].values);
  EXPECT_EQ(read.scalars[1].values[5], 6);
  EXPECT_TRUE(std::isnan(read.scalars[1].values[2]));
}

TEST(Attributes, ColorsOfObjAndOff) {
  const TemporaryFolder folder;
  Mesh mesh = test::octahedron();
  for (int v = 0; v < 6; ++v)
    mesh.colors.push_back(
        {static_cast<std::uint8_t>(v), static_cast<std::uint8_t>(51 * v), static_cast<std::uint8_t>(255 - v)});
  for (const char* const name : {"m.obj", "m.off"}) {
    write_mesh(mesh, folder / name);
    const Mesh read = read_mesh(folder / name);
    EXPECT_EQ(read.colors, mesh.colors) << name;
    EXPECT_EQ(read.positions, mesh.positions);
    EXPECT_EQ(read.faces, mesh.faces);
  }
}

// All 256 levels survive the decimals of an OBJ file.
TEST(Attributes, EveryByteOfColorThroughObj) {
  const TemporaryFolder folder;
  Mesh mesh;
  for (int v = 0; v < 256; ++v) {
    mesh.positions.emplace_back(v, 0, 0);
    mesh.colors.push_back({static_cast<std::uint8_t>(v), 0, 255});
  }
  write_mesh(mesh, folder / "m.obj");
  EXPECT_EQ(read_mesh(folder / "m.obj").colors, mesh.colors);
}

TEST(Attributes, LabelsAreRecognizedByNameAndWholeNumbers) {
  const TemporaryFolder folder;
  const auto kinds = [&](const std::vector<std::string>& names, const std::string& values) {
    std::string text = "# x y z";
    for (const std::string& name : names) text += " " + name;
    text += "\n0 0 0";
    for (std::size_t c = 0; c < names.size(); ++c) text += " " + values;
    test::write_bytes(folder / "p.xyz", text + "\n");
    std::vector<bool> labels;
    for (const ScalarColumn& column : read_points(folder / "p.xyz").scalars)
      labels.push_back(column.kind == ScalarKind::label);
    return labels;
  };
  EXPECT_THAT(kinds({"Classification", "scalar_Label", "segment_id", "InstanceID", "clusters", "class"}, "3"),
              testing::Each(true));
  EXPECT_THAT(kinds({"label", "class"}, "nan"), testing::Each(true));
  EXPECT_THAT(kinds({"label", "class"}, "2.5"), testing::Each(false));
  EXPECT_THAT(kinds({"intensity", "return_number", "grid", "parting"}, "3"), testing::Each(false));
}

}  // namespace
}  // namespace gpsrecon
