// Unusual and broken files with the outcome that each must have.

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/io/io.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "support/data_files.h"

namespace gpsrecon {
namespace {

using testing::HasSubstr;

std::filesystem::path corpus_dir() {
  return std::filesystem::path(GPSRECON_SOURCE_DIR) / "tests" / "corpus";
}

struct Case {
  std::string file, reader, outcome;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.file << " as " << c.reader;
}

std::vector<Case> read_manifest() {
  std::ifstream manifest(corpus_dir() / "manifest.tsv");
  std::vector<Case> cases;
  for (std::string line; std::getline(manifest, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    Case& c = cases.emplace_back();
    std::getline(fields, c.file, '\t');
    std::getline(fields, c.reader, '\t');
    std::getline(fields, c.outcome, '\t');
  }
  return cases;
}

// "ok <vertices> <faces>"
std::string outcome_of(const std::string& path, const std::string& reader) {
  const auto ok = [](std::size_t vertices, std::size_t faces) {
    return "ok " + std::to_string(vertices) + " " + std::to_string(faces);
  };
  try {
    if (reader == "points") return ok(read_points(path).size(), 0);
    if (reader == "mixture") return ok(read_mixture(path).size(), 0);
    if (reader == "covmesh") {
      const CovMesh mesh = read_covmesh(path);
      return ok(mesh.vertices.size(), mesh.faces.size());
    }
    const Mesh mesh = read_mesh(path);
    return ok(mesh.positions.size(), mesh.faces.size());
  } catch (const InputError& error) {
    return std::string("error ") + error.what();
  }
}

class Corpus : public testing::TestWithParam<Case> {};

TEST_P(Corpus, HasTheExpectedOutcome) {
  const std::string path = (corpus_dir() / GetParam().file).string();
  const std::string outcome = outcome_of(path, GetParam().reader);
  if (GetParam().outcome.starts_with("error ")) {
    EXPECT_THAT(outcome, testing::StartsWith("error " + path + ": "));
    EXPECT_THAT(outcome, HasSubstr(GetParam().outcome.substr(6)));
    EXPECT_THAT(outcome, testing::Not(HasSubstr("\n")));
  } else {
    EXPECT_EQ(outcome, GetParam().outcome);
  }
}

INSTANTIATE_TEST_SUITE_P(Files, Corpus, testing::ValuesIn(read_manifest()),
                         [](const testing::TestParamInfo<Case>& test_case) {
                           std::string name = test_case.param.reader + "_of_" + test_case.param.file;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

TEST(CorpusManifest, NamesEveryFile) {
  const std::vector<Case> cases = read_manifest();
  for (const auto& entry : std::filesystem::directory_iterator(corpus_dir())) {
    const std::string name = entry.path().filename().string();
    if (name == "manifest.tsv") continue;
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [&name](const Case& c) { return c.file == name; })) << name;
  }
}

TEST(CorpusValues, NumbersBeyondTheRangeOfDouble) {
  const std::string path = (corpus_dir() / "ply_beyond_double.ply").string();
  const Vec3 p = read_points(path).positions.at(0);
  EXPECT_EQ(p.x(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(p.y(), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(p.z(), 0);
}

TEST(CorpusValues, StripsTurnTheSameWay) {
  const Mesh mesh = read_mesh((corpus_dir() / "ply_tristrips.ply").string());
  const std::vector<Index> expected{0, 1, 2, 2, 1, 3, 3, 2, 1};
  EXPECT_EQ(mesh.faces.corners, expected);
}

// Lines may end with a carriage return alone, and data may begin with what looks like a line feed.
TEST(CorpusValues, DataThatBeginWithALineFeed) {
  for (const char* const name : {"ply_crlf_binary_begins_with_newline.ply", "ply_cr_binary_begins_with_newline.ply",
                                 "ply_lf_binary_begins_with_newline.ply"}) {
    const Vec3 p = read_points((corpus_dir() / name).string()).positions.at(0);
    EXPECT_NEAR(p.x(), 2.1568, 1e-4) << name;
    EXPECT_EQ(p.y(), 2) << name;
    EXPECT_EQ(p.z(), 3) << name;
  }
}

// Files met in other projects.

TEST(BadData, AssimpCubeWithMixedLineEnds) {
  GPSRECON_DATA_FILE(path, "bad/assimp_cube_binary_header_with_RN_newline.ply");
  const Mesh mesh = read_mesh(path.string());
  ASSERT_EQ(mesh.positions.size(), 8u);
  for (const Vec3& p : mesh.positions)
    for (const double coordinate : p) EXPECT_TRUE(coordinate == 0 || coordinate == 1) << p.transpose();
  EXPECT_EQ(mesh.faces.size(), 12u);
  double volume = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    Mat3 corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = mesh.positions[mesh.faces[f][static_cast<std::size_t>(k)]];
    volume += (corners(0, 0) * (corners(1, 1) * corners(2, 2) - corners(1, 2) * corners(2, 1)) -
               corners(0, 1) * (corners(1, 0) * corners(2, 2) - corners(1, 2) * corners(2, 0)) +
               corners(0, 2) * (corners(1, 0) * corners(2, 1) - corners(1, 1) * corners(2, 0))) /
              6;
  }
  EXPECT_NEAR(std::abs(volume), 1, 1e-12);
}

TEST(BadData, DracoInfiniteRowsAreKept) {
  GPSRECON_DATA_FILE(path, "bad/draco_float_inf_point_cloud.ply");
  const PointCloud cloud = read_points(path.string());
  ASSERT_EQ(cloud.size(), 16u);
  std::size_t finite = 0;
  for (const Vec3& p : cloud.positions) finite += p.allFinite() ? 1 : 0;
  EXPECT_EQ(finite, 13u);
  EXPECT_EQ(cloud.positions[0].z(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(cloud.positions[1].z(), -std::numeric_limits<double>::infinity());
}

TEST(BadData, HapplyShelvesAgree) {
  GPSRECON_DATA_FILE(little, "bad/happly_platonic_shelf.ply");
  GPSRECON_DATA_FILE(big, "bad/happly_platonic_shelf_big_endian.ply");
  const Mesh a = read_mesh(little.string()), b = read_mesh(big.string());
  EXPECT_EQ(a.positions.size(), 50u);
  EXPECT_EQ(a.faces.size(), 50u);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.faces, b.faces);
}

TEST(BadData, PdalDoubles) {
  GPSRECON_DATA_FILE(path, "bad/pdal_issue_2421.ply");
  const PointCloud cloud = read_points(path.string());
  EXPECT_EQ(cloud.positions, std::vector<Vec3>{Vec3(1.23457, 12345.67890, 1234567890.12345)});
  ASSERT_EQ(cloud.scalars.size(), 1u);
  EXPECT_EQ(cloud.scalars[0].name, "i");
  EXPECT_EQ(cloud.scalars[0].values, std::vector<double>{1234567890});
}

TEST(BadData, TrimeshFilesWithoutFaces) {
  GPSRECON_DATA_FILE(empty, "bad/trimesh_empty.ply");
  GPSRECON_DATA_FILE(points, "bad/trimesh_points_emptyface.ply");
  EXPECT_TRUE(read_points(empty.string()).empty());
  EXPECT_EQ(probe_file(empty.string()), FileKind::points);
  EXPECT_EQ(read_points(points.string()).size(), 1024u);
  EXPECT_EQ(probe_file(points.string()), FileKind::points);
}

TEST(Scans, NumbersOfPoints) {
  GPSRECON_DATA_FILE(scans, "scans");
  const std::pair<const char*, std::size_t> expected[] = {{"stanford_bunny_registered.ply", 362272},
                                                          {"kinect_capture0001.ply", 307200},
                                                          {"laser_room_scan1.ply", 112586},
                                                          {"lidar_autzen_trim.ply", 110000},
                                                          {"mvs2view_statue.ply", 12892},
                                                          {"cgal_kitten.xyz", 5210},
                                                          {"cgal_hippo1.ply", 6104},
                                                          {"cgal_sphere_20k.xyz", 21000}};
  for (const auto& [name, count] : expected) EXPECT_EQ(read_points((scans / name).string()).size(), count) << name;
}

}  // namespace
}  // namespace gpsrecon
