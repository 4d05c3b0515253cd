// What is written comes back.

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "small_files.h"

#include "support/same_bytes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;
using test::read_bytes;
using test::same_bytes;
using test::TemporaryFolder;

// Equality of bits: NaN equals itself, and 0 differs from -0.
void expect_same_bits(const Mixture& a, const Mixture& b) {
  EXPECT_TRUE(same_bytes(a.means, b.means));
  EXPECT_TRUE(same_bytes(a.covariances, b.covariances));
  EXPECT_TRUE(same_bytes(a.weights, b.weights));
  EXPECT_TRUE(same_bytes(a.normals, b.normals));
  EXPECT_TRUE(same_bytes(a.normal_variances, b.normal_variances));
  EXPECT_TRUE(same_bytes(a.kernels, b.kernels));
  EXPECT_TRUE(same_bytes(a.outward, b.outward));
  EXPECT_EQ(a.sigma0, b.sigma0);
  EXPECT_EQ(a.frame, b.frame);
}

const Frame utm{Vec3(637177.98, 849393.95, 411.19), 9};

class BothEncodings : public testing::TestWithParam<PlyEncoding> {
 protected:
  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "file.ply";
};
INSTANTIATE_TEST_SUITE_P(Ply, BothEncodings, testing::Values(PlyEncoding::binary, PlyEncoding::ascii),
                         [](const auto& test_case) {
                           return test_case.param == PlyEncoding::binary ? "binary" : "ascii";
                         });

TEST_P(BothEncodings, MixtureAsStored) {
  for (const Frame& frame : {Frame{}, utm, Frame{Vec3(1e-9, 0, -3e-10), -30}, Frame{Vec3(0.1, 0.2, 0.3), 0}})
    for (const bool with_normals : {false, true}) {
      const Mixture mixture = test::random_mixture(100, frame, with_normals);
      write_mixture(mixture, path_, GetParam());
      EXPECT_EQ(probe_file(path_), FileKind::mixture);
      expect_same_bits(read_mixture(path_), as_stored(mixture));
    }
}

TEST_P(BothEncodings, MixtureWithKernelsAndOutwardDirections) {
  for (const bool with_normals : {false, true})
    for (const bool with_kernels : {false, true}) {
      Mixture mixture = test::random_mixture(50, utm, with_normals);
      Random random(31);
      mixture.outward = random.vectors(mixture.size());
      for (std::size_t s = 0; with_kernels && s < mixture.size(); ++s)
        mixture.kernels.push_back(random.uniform(0, 0.1));
      write_mixture(mixture, path_, GetParam());
      const Mixture read = read_mixture(path_);
      expect_same_bits(read, as_stored(mixture));
      EXPECT_EQ(read.outward, mixture.outward);
      EXPECT_EQ(read.kernels, mixture.kernels);
    }
}

// World coordinates are rounded, so means come back to the rounding of the largest coordinate; all else exactly.
TEST_P(BothEncodings, MixtureToTheRoundingOfWorldCoordinates) {
  const Mixture mixture = test::random_mixture(100, utm, true);
  write_mixture(mixture, path_, GetParam());
  const Mixture read = read_mixture(path_);
  EXPECT_TRUE(same_bytes(read.covariances, mixture.covariances));
  EXPECT_TRUE(same_bytes(read.weights, mixture.weights));
  EXPECT_EQ(read.sigma0, mixture.sigma0);
  EXPECT_EQ(read.frame, mixture.frame);
  for (std::size_t s = 0; s < mixture.size(); ++s) {
    EXPECT_LE((read.means[s] - mixture.means[s]).lpNorm<Eigen::Infinity>(), 0x1p-33 * 0x1p-9);  // half an ulp of 2^19
    EXPECT_LE((read.normals[s] - mixture.normals[s]).norm(), 1e-15);
    EXPECT_NEAR(read.normal_variances[s], mixture.normal_variances[s], 1e-15);
  }
}

// Where world coordinates are exact, every bit comes back: here means are multiples of 2^-30 and the frame is at
// integers.
TEST_P(BothEncodings, MixtureBitForBitWhereWorldCoordinatesAreExact) {
  for (const Frame& frame : {Frame{Vec3(637177, 849393, 411), 9}, Frame{Vec3::Zero(), -7}, Frame{}}) {
    Mixture mixture = test::random_mixture(100, frame, false);
    for (Vec3& mean : mixture.means)
      for (double& coordinate : mean) coordinate = std::round(coordinate * 0x1p30) * 0x1p-30;
    write_mixture(mixture, path_, GetParam());
    expect_same_bits(read_mixture(path_), mixture);
  }
}

TEST_P(BothEncodings, CovMesh) {
  for (const bool with_normals : {false, true}) {
    const CovMesh mesh = test::octahedron_covmesh(utm, with_normals);
    write_covmesh(mesh, path_, GetParam());
    EXPECT_EQ(probe_file(path_), FileKind::covmesh);
    const CovMesh read = read_covmesh(path_);
    EXPECT_EQ(read.rules, mesh.rules);
    expect_same_bits(read.vertices, as_stored(mesh.vertices));
    EXPECT_EQ(read.faces, mesh.faces);
  }
}

TEST_P(BothEncodings, RulesOfTheSurface) {
  CovMesh mesh = test::octahedron_covmesh(utm, false);
  for (const Scheme scheme : {Scheme::loop, Scheme::catmull_clark})
    for (const LoopWeights weights : {LoopWeights::loop, LoopWeights::warren})
      for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp}) {
        mesh.rules = {scheme, weights, corners};
        write_covmesh(mesh, path_, GetParam());
        EXPECT_EQ(read_covmesh(path_).rules, mesh.rules);
      }
}

// Columns hold world units under the names of the format, whoever reads them.
TEST_P(BothEncodings, MixtureColumns) {
  Mixture mixture = test::random_mixture(1, Frame{Vec3(100, 200, 300), 3}, true);
  mixture.means[0] = {0.5, -0.25, 1};
  mixture.covariances[0] = {1, 0.125, 0.25, 2, 0.5, 3};
  mixture.weights[0] = 42;
  mixture.normals[0] = {0, 0, 1};
  mixture.normal_variances[0] = 0.5;
  mixture.sigma0 = 0.25;
  write_mixture(mixture, path_, GetParam());
  const PointCloud columns = read_points(path_);
  EXPECT_TRUE(columns.frame.is_identity());
  EXPECT_EQ(columns.positions[0], Vec3(104, 198, 308));
  const std::vector<std::pair<std::string, double>> expected{
      {"covxx", 64},  {"covxy", 8},   {"covxz", 16}, {"covyy", 128}, {"covyz", 32},
      {"covzz", 192}, {"weight", 42}, {"nvx", 0},    {"nvy", 0},     {"nvz", 1.5}};
  ASSERT_EQ(columns.scalars.size(), expected.size());
  for (std::size_t c = 0; c < expected.size(); ++c) {
    EXPECT_EQ(columns.scalars[c].name, expected[c].first);
    EXPECT_EQ(columns.scalars[c].values[0], expected[c].second);
  }
  EXPECT_THAT(read_bytes(path_), testing::HasSubstr(" frame 100 200 300 3 sigma0 2 spacing 0\n"));
}

TEST_P(BothEncodings, MixtureWithoutCommentIsInTheIdentityFrame) {
  test::write_bytes(
      path_,
      "ply\nformat ascii 1.0\ncomment gpsrecon is a word\nelement component 1\nproperty float covzz\n"
      "property float x\nproperty float y\nproperty float z\nproperty float covxx\nproperty float covxy\n"
      "property float covxz\nproperty float covyy\nproperty float covyz\nend_header\n6 1 2 3 4 0.5 0.25 5 0\n");
  const Mixture mixture = read_mixture(path_);
  EXPECT_TRUE(mixture.frame.is_identity());
  EXPECT_EQ(mixture.sigma0, 0);
  EXPECT_EQ(mixture.means, std::vector<Vec3>{Vec3(1, 2, 3)});
  EXPECT_EQ(mixture.covariances[0], (Sym3{4, 0.5, 0.25, 5, 0, 6}));
  EXPECT_EQ(mixture.weights, std::vector<double>{1});
  EXPECT_TRUE(mixture.normals.empty());
}

TEST_P(BothEncodings, PointsWithAllAttributesAreLossless) {
  const PointCloud cloud = test::small_cloud();
  write_points(cloud, path_, GetParam());
  EXPECT_EQ(probe_file(path_), FileKind::points);
  const PointCloud read = read_points(path_);
  EXPECT_TRUE(same_bytes(read.positions, cloud.positions));
  EXPECT_TRUE(same_bytes(read.normals, cloud.normals));
  EXPECT_TRUE(same_bytes(read.sensors, cloud.sensors));
  EXPECT_EQ(read.colors, cloud.colors);
  ASSERT_EQ(read.scalars.size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_EQ(read.scalars[c].name, cloud.scalars[c].name);
    EXPECT_TRUE(same_bytes(read.scalars[c].values, cloud.scalars[c].values));
  }
}

TEST_P(BothEncodings, PointsAreWrittenInTheWorld) {
  PointCloud cloud;
  cloud.frame = {Vec3(10, 20, 30), 2};
  cloud.positions = {Vec3(1, 0, -1)};
  cloud.sensors = {Vec3(0, 0, 0.5)};
  write_points(cloud, path_, GetParam());
  const PointCloud read = read_points(path_);
  EXPECT_EQ(read.positions, std::vector<Vec3>{Vec3(14, 20, 26)});
  EXPECT_EQ(read.sensors, std::vector<Vec3>{Vec3(10, 20, 32)});
  EXPECT_TRUE(read.frame.is_identity());
}

TEST_P(BothEncodings, SpecialNumbers) {
  PointCloud cloud;
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  cloud.positions = {Vec3(nan, inf, -inf), Vec3(-0.0, 5e-324, 1.7976931348623157e308), Vec3(0.1f, 1e-45f, 3.4e38f)};
  write_points(cloud, path_, GetParam());
  const PointCloud read = read_points(path_);
  ASSERT_EQ(read.size(), 3u);
  EXPECT_TRUE(std::isnan(read.positions[0].x()));
  EXPECT_EQ(read.positions[0].y(), inf);
  EXPECT_EQ(read.positions[0].z(), -inf);
  EXPECT_TRUE(std::signbit(read.positions[1].x()));
  EXPECT_EQ(read.positions[1].tail<2>(), cloud.positions[1].tail<2>());
  EXPECT_EQ(read.positions[2], cloud.positions[2]);
}

TEST_P(BothEncodings, ScalarNamesThatAHeaderCannotHold) {
  PointCloud cloud;
  cloud.positions = {Vec3(1, 2, 3)};
  for (const char* const name : {"two words", "x", "", "line\nfeed", "two_words"})
    cloud.scalars.push_back({name, {0.1}});
  write_points(cloud, path_, GetParam());
  const PointCloud read = read_points(path_);
  EXPECT_EQ(read.positions, cloud.positions);
  ASSERT_EQ(read.scalars.size(), 5u);
  std::vector<std::string> names;
  for (const ScalarColumn& column : read.scalars) names.push_back(column.name);
  EXPECT_THAT(names, testing::ElementsAre("two_words", "x_", "scalar", "line_feed", "two_words_"));
}

TEST_P(BothEncodings, EmptyThings) {
  write_points({}, path_, GetParam());
  EXPECT_TRUE(read_points(path_).empty());
  write_mixture({}, path_, GetParam());
  EXPECT_TRUE(read_mixture(path_).empty());
  EXPECT_EQ(probe_file(path_), FileKind::mixture);
  write_covmesh({}, path_, GetParam());
  EXPECT_TRUE(read_covmesh(path_).faces.empty());
  EXPECT_EQ(probe_file(path_), FileKind::covmesh);
  write_mesh({}, path_, GetParam());
  EXPECT_TRUE(read_mesh(path_).positions.empty());
}

Mesh mesh_with_attributes() {
  Mesh mesh = test::octahedron();
  mesh.scalars = {{"curvature", {}}};
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    mesh.normals.push_back(mesh.positions[v]);
    mesh.colors.push_back({static_cast<std::uint8_t>(v), 100, 200});
    mesh.sigma.push_back(0.125 * static_cast<double>(v));
    mesh.scalars[0].values.push_back(0.5 * static_cast<double>(v));
  }
  const std::vector<Index> quad{0, 2, 1, 3};
  mesh.faces.add(quad);
  return mesh;
}

TEST_P(BothEncodings, MeshWithAllAttributes) {
  const Mesh mesh = mesh_with_attributes();
  write_mesh(mesh, path_, GetParam());
  EXPECT_EQ(probe_file(path_), FileKind::mesh);
  const Mesh read = read_mesh(path_);
  EXPECT_EQ(read.positions, mesh.positions);
  EXPECT_EQ(read.faces, mesh.faces);
  EXPECT_EQ(read.normals, mesh.normals);
  EXPECT_EQ(read.colors, mesh.colors);
  EXPECT_EQ(read.sigma, mesh.sigma);
  ASSERT_EQ(read.scalars.size(), 1u);
  EXPECT_EQ(read.scalars[0].name, "curvature");
  EXPECT_EQ(read.scalars[0].values, mesh.scalars[0].values);
  const PointCloud vertices = read_points(path_);
  EXPECT_EQ(vertices.positions, mesh.positions);
  EXPECT_EQ(vertices.normals, mesh.normals);
}

TEST_P(BothEncodings, MeshIsWrittenInTheWorld) {
  Mesh mesh = mesh_with_attributes();
  mesh.frame = {Vec3(1, 2, 3), -2};
  write_mesh(mesh, path_, GetParam());
  const Mesh read = read_mesh(path_);
  EXPECT_EQ(read.positions[0], Vec3(1.25, 2, 3));
  EXPECT_EQ(read.sigma[1], 0.25 * 0.125);
  EXPECT_EQ(read.normals, mesh.normals);
  EXPECT_TRUE(read.frame.is_identity());
}

// float is kept while it moves no vertex by more than a millionth of the diagonal; 2^24 + 1 is the first integer that
// float moves, by one.
TEST_P(BothEncodings, MeshPositionsAreDoubleWhereFloatIsTooCoarse) {
  Mesh mesh = test::octahedron();
  const auto stored_type = [&] {
    write_mesh(mesh, path_, GetParam());
    return read_bytes(path_).find("property float x\n") != std::string::npos ? "float" : "double";
  };
  for (Vec3& p : mesh.positions) p = 0.1 * p + Vec3(0.3, 0.3, 0.3);
  EXPECT_STREQ(stored_type(), "float");
  for (Vec3& p : mesh.positions) p.x() = 16777217;
  EXPECT_STREQ(stored_type(), "double");
  EXPECT_EQ(read_mesh(path_).positions, mesh.positions);
  mesh.positions[0].y() = 0.9e6;
  EXPECT_STREQ(stored_type(), "double");
  mesh.positions[0].y() = 1.1e6;
  EXPECT_STREQ(stored_type(), "float");
  for (Vec3& p : mesh.positions) p *= 1e40;  // beyond float
  EXPECT_STREQ(stored_type(), "double");
}

TEST_P(BothEncodings, FacesOfManyCorners) {
  Mesh mesh;
  std::vector<Index> polygon;
  for (Index v = 0; v < 1000; ++v) {
    mesh.positions.emplace_back(std::cos(0.00628 * v), std::sin(0.00628 * v), 0);
    polygon.push_back(v);
  }
  mesh.faces.add(polygon);
  write_mesh(mesh, path_, GetParam());
  EXPECT_EQ(read_mesh(path_).faces, mesh.faces);
}

TEST(MeshFormats, OffAndObjKeepEveryBit) {
  const TemporaryFolder folder;
  Mesh mesh = test::octahedron();
  Random random(11);
  for (Vec3& p : mesh.positions) {
    p = 1e5 * random.vector();
    mesh.normals.push_back(random.vector().normalized());
  }
  mesh.positions.push_back(random.vector());  // in no face
  mesh.normals.emplace_back(0, 0, 1);
  const std::vector<Index> quad{0, 2, 1, 3};
  mesh.faces.add(quad);
  for (const char* const name : {"mesh.off", "mesh.obj", "MESH.OBJ"}) {
    write_mesh(mesh, folder / name);
    EXPECT_EQ(probe_file(folder / name), FileKind::mesh);
    const Mesh read = read_mesh(folder / name);
    EXPECT_TRUE(same_bytes(read.positions, mesh.positions)) << name;
    EXPECT_EQ(read.faces, mesh.faces) << name;
    EXPECT_TRUE(same_bytes(read_points(folder / name).positions, mesh.positions)) << name;
  }
  // Normals of vertices that no face uses have no place in an OBJ file.
  mesh.positions.pop_back();
  mesh.normals.pop_back();
  write_mesh(mesh, folder / "mesh.obj");
  EXPECT_TRUE(same_bytes(read_mesh(folder / "mesh.obj").normals, mesh.normals));
}

TEST(MeshFormats, CreasedObjNormalsAreGivenUp) {
  const TemporaryFolder folder;
  const std::string path = folder / "crease.obj";
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvn 0 1 0\n";
  test::write_bytes(path, vertices + "f 1//1 2//1 3//1\nf 1//2 2//2 4//2\n");
  EXPECT_TRUE(read_mesh(path).normals.empty());
  test::write_bytes(path, vertices + "f 1//1 2//1 3//1\nf 1//1 2//1 4//-1\n");
  EXPECT_EQ(read_mesh(path).normals, (std::vector<Vec3>{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 1, 0}}));
}

TEST(MeshFormats, StlMergesCornersAndSplitsPolygons) {
  const TemporaryFolder folder;
  const std::string path = folder / "mesh.stl";
  Mesh mesh = test::octahedron();
  mesh.frame = {Vec3(4, 0, 0), 1};
  mesh.faces = test::octahedron().faces;
  write_mesh(mesh, path);
  Mesh read = read_mesh(path);
  ASSERT_EQ(read.positions.size(), 6u);
  ASSERT_EQ(read.faces.size(), 8u);
  for (std::size_t f = 0; f < 8; ++f)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(read.positions[read.faces[f][k]], mesh.frame.to_world(mesh.positions[mesh.faces[f][k]]));

  Mesh square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<Index> quad{0, 1, 2, 3};
  square.faces.add(quad);
  write_mesh(square, path);
  read = read_mesh(path);
  EXPECT_EQ(read.positions, square.positions);
  EXPECT_EQ(read.faces.corners, (std::vector<Index>{0, 1, 2, 0, 2, 3}));
  // The normal of each triangle stands in front of its corners.
  const std::string bytes = read_bytes(path);
  ASSERT_EQ(bytes.size(), 84u + 2 * 50u);
  float normal[3];
  for (const std::size_t triangle : {84u, 134u}) {
    std::memcpy(normal, bytes.data() + triangle, sizeof(normal));
    EXPECT_EQ(normal[0], 0);
    EXPECT_EQ(normal[1], 0);
    EXPECT_EQ(normal[2], 1);
  }
}

// The header of a file of faces is probed without the data behind it, wherever it ends.
TEST(Probe, LongHeader) {
  const TemporaryFolder folder;
  const std::string path = folder / "long.ply";
  std::string header = "ply\nformat ascii 1.0\n";
  for (int i = 0; i < 5000; ++i) header += "comment a long history of processing steps\n";
  test::write_bytes(
      path, header + "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n");
  EXPECT_EQ(probe_file(path), FileKind::points);
  EXPECT_EQ(read_points(path).size(), 1u);
}

}  // namespace
}  // namespace gpsrecon
