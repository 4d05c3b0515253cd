#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/io/io.h>
#include <gpsrecon/report/file_hash.h>
#include <gpsrecon/scan/gallery.h>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "clouds.h"
#include "process.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class Scan : public testing::Test {
 protected:
  TemporaryFolder folder;
  std::string path(const std::string& name) const { return folder / name; }
  /// `arguments` are separated by blanks; outputs lie in the folder.
  void scan(const std::string& arguments) {
    const ProcessResult result = run(words_of("scan " + arguments), {.folder = folder.path().string()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, IsEmpty());
  }
};

TEST_F(Scan, of_a_shape_lies_on_it_up_to_the_noise) {
  scan("shape:block s.ply --points 4000 --noise 0.1%");
  const auto block = make_shape("block");
  const PointCloud cloud = read_points(path("s.ply"));
  ASSERT_EQ(cloud.size(), 4000u);
  EXPECT_TRUE(cloud.normals.empty());
  EXPECT_TRUE(cloud.sensors.empty());
  double square = 0;
  for (const Vec3& p : cloud.positions) square += std::pow(block->distance(p) / block->diagonal(), 2) / 4000;
  // The noise is along the ray; the distance is shorter by the cosine, on average of its square between 0.3 and 0.9.
  EXPECT_GT(std::sqrt(square), 0.0005);
  EXPECT_LT(std::sqrt(square), 0.001);
}

TEST_F(Scan, depends_on_the_seed_only) {
  scan("shape:vase a.ply --quality s3 --points 3000 --threads 1 --truth a.obj");
  scan("shape:vase b.ply --quality s3 --points 3000 --threads 4 --truth b.obj");
  scan("shape:vase c.ply --quality s3 --points 3000 --seed 2");
  EXPECT_EQ(hash_file(path("a.ply")), hash_file(path("b.ply")));
  EXPECT_EQ(hash_file(path("a.obj")), hash_file(path("b.obj")));
  EXPECT_NE(hash_file(path("a.ply")), hash_file(path("c.ply")));
}

TEST_F(Scan, options_change_the_grade_wherever_they_stand) {
  scan("shape:sphere a.ply --points 700 --noise 0 --quality s1");
  scan("shape:sphere b.ply --quality s1 --noise 0 --points 700");
  EXPECT_EQ(hash_file(path("a.ply")), hash_file(path("b.ply")));
  const PointCloud cloud = read_points(path("a.ply"));
  ASSERT_EQ(cloud.size(), 700u);
  for (const Vec3& p : cloud.positions) ASSERT_NEAR(p.norm(), 1, 1e-6);
}

TEST_F(Scan, writes_normals_and_sensors_when_asked_to) {
  scan("shape:sphere surface.ply --points 500 --normals surface --sensors");
  scan("shape:sphere sensor.ply --points 500 --normals sensor");
  const PointCloud surface = read_points(path("surface.ply")), sensor = read_points(path("sensor.ply"));
  ASSERT_EQ(surface.normals.size(), 500u);
  ASSERT_EQ(surface.sensors.size(), 500u);
  ASSERT_EQ(sensor.normals.size(), 500u);
  EXPECT_TRUE(sensor.sensors.empty());
  for (std::size_t i = 0; i < 500; ++i) {
    ASSERT_EQ(surface.positions[i], sensor.positions[i]);
    ASSERT_LT((surface.normals[i] - surface.positions[i]).norm(), 1e-6);  // of the unit sphere
    ASSERT_NEAR(surface.sensors[i].norm(), 4 * make_shape("sphere")->bounding_radius(), 1e-5);
    ASSERT_LT((sensor.normals[i] - (surface.sensors[i] - surface.positions[i]).normalized()).norm(), 1e-5);
  }
}

TEST_F(Scan, of_a_mesh_far_away_keeps_its_digits) {
  Mesh mesh = make_shape("block")->mesh(0.001);
  const Vec3 place(600'000, 5'000'000, 300);
  for (Vec3& p : mesh.positions) p += place;
  write_mesh(mesh, path("block.ply"));
  scan("block.ply s.ply --points 2000 --truth truth.ply");
  const auto block = make_shape("block");
  for (const Vec3& p : read_points(path("s.ply")).positions)
    ASSERT_LT(std::abs(block->distance(p - place)), 0.001 + 1e-6 * block->diagonal());
  EXPECT_EQ(read_mesh(path("truth.ply")).faces.size(), mesh.faces.size());
}

TEST_F(Scan, truth_is_as_near_as_asked_for) {
  scan("shape:torus s.ply --points 100 --truth t.ply --truth-tolerance 0.1%");
  const auto torus = make_shape("torus");
  const Mesh truth = read_mesh(path("t.ply"));
  for (std::size_t f = 0; f < truth.faces.size(); ++f) {
    const auto face = truth.faces[f];
    const Vec3 middle = (truth.positions[face[0]] + truth.positions[face[1]] + truth.positions[face[2]]) / 3;
    ASSERT_LT(std::abs(torus->distance(middle)), 0.001 * torus->diagonal());
  }
}

TEST_F(Scan, refuses_what_cannot_be_scanned) {
  write_bytes(folder / "points.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  write_bytes(folder / "line.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n");
  const auto fails = [&](const std::string& arguments, int code, const std::string& message) {
    const ProcessResult result = run(words_of("scan " + arguments), {.folder = folder.path().string()});
    EXPECT_EQ(result.exit_code, code) << arguments << '\n' << result.err;
    EXPECT_THAT(result.err, HasSubstr(message)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(folder / "s.ply"));
  };
  fails("shape:teapot s.ply", 2, "teapot");
  fails("shape:sphere s.ply --quality s4", 2, "s1|s2|s3");
  fails("shape:sphere s.ply --points 0", 2, "points");
  fails("shape:sphere s.ply --outliers 0.6 --spikes 0.6", 2, "1.2");
  fails("shape:sphere s.ply --max-incidence 91", 2, "max-incidence");
  fails("shape:sphere s.ply --truth s.ply", 2, "same file");
  fails("shape:sphere s.ply --truth s.xyz", 6, "s.xyz");
  fails("shape:sphere s.ply --truth-tolerance 100%", 2, "truth-tolerance");
  fails("points.xyz s.ply", 3, "points.xyz");
  fails("line.off s.ply", 4, "line.off");
  fails("shape:sphere s.ply --max-incidence 0.0000001", 4, "shape:sphere");
}

// Whoever makes the datasets gets the same bytes.
TEST_F(Scan, manifest_describes_the_datasets) {
  std::ifstream file(GPSRECON_SOURCE_DIR "/datasets/manifest.json");
  const auto manifest = nlohmann::json::parse(file);
  ASSERT_FALSE(manifest["datasets"].empty());
  for (const auto& dataset : manifest["datasets"]) {
    const std::string name = dataset["file"];
    scan(dataset["surface"].get<std::string>() + " " + name + " " + dataset["options"].get<std::string>() + " --seed " +
         std::to_string(dataset["seed"].get<int>()));
    EXPECT_EQ(hash_file(path(name)), dataset["hash"]) << name;
    EXPECT_EQ(read_points(path(name)).size(), dataset["points"]) << name;
  }
}

}  // namespace
}  // namespace gpsrecon::test
