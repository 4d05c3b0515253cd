// Rows of numbers, PCD, and which format a name stands for.

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gtest/gtest.h>

#include "small_files.h"
#include "support/data_files.h"
#include "text.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::TemporaryFolder;
using test::write_bytes;
using testing::HasSubstr;

template <class Error>
std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

class Xyz : public testing::Test {
 protected:
  PointCloud read(const std::string& text, const std::string& name = "points.xyz") {
    write_bytes(folder_ / name, text);
    return read_points(folder_ / name);
  }
  const TemporaryFolder folder_;
};

const std::vector<Vec3> two_points{{1, 2, 3}, {-4, 0.5, 6e2}};

TEST_F(Xyz, Separators) {
  for (const char* const text :
       {"1 2 3\n-4 0.5 6e2\n", "1,2,3\n-4,.5,600\n", "1;2;3\n-4;5e-1;6e+2", "\t1\t2  3 \r\n  -4 0.5 +600\r\n\r\n",
        "1 , 2 , 3\n-4 , 0.5 , 600\n", "1,2,3,\n-4,0.5,600,\n", "1 2 3\r-4 0.5 600\r"})
    EXPECT_EQ(read(text).positions, two_points) << text;
  for (const char* const name : {"a.txt", "a.asc", "a.csv", "a.XYZ"})
    EXPECT_EQ(read("1 2 3\n-4 0.5 600\n", name).positions, two_points) << name;
}

TEST_F(Xyz, CommentsAndHeaders) {
  for (const char* const text :
       {"# comment\n1 2 3\n// another\n-4 0.5 600\n", "x y z\n1 2 3\n-4 0.5 600\n", "X,Y,Z\n1,2,3\n-4,0.5,600\n",
        "//X Y Z\n1 2 3\n-4 0.5 600\n", "\"x\";\"y\";\"z\"\n1;2;3\n-4;0.5;600\n",
        "easting northing height\n1 2 3\n-4 0.5 600\n", "1 2 3 # first\n-4 0.5 600 // second\n",
        "# x y z of the scan\n1 2 3\n-4 0.5 600\n"})
    EXPECT_EQ(read(text).positions, two_points) << text;
}

TEST_F(Xyz, NamedColumns) {
  const PointCloud cloud = read("intensity,z,y,x,red,green,blue,nx,ny,nz\n7,3,2,1,255,128,0,0,0,1\n");
  EXPECT_EQ(cloud.positions, std::vector<Vec3>{Vec3(1, 2, 3)});
  EXPECT_EQ(cloud.normals, std::vector<Vec3>{Vec3(0, 0, 1)});
  EXPECT_EQ(cloud.colors, (std::vector<Color>{{255, 128, 0}}));
  ASSERT_EQ(cloud.scalars.size(), 1u);
  EXPECT_EQ(cloud.scalars[0].name, "intensity");
  EXPECT_EQ(cloud.scalars[0].values, std::vector<double>{7});
}

TEST_F(Xyz, SixColumnsAreNormalsOrColors) {
  PointCloud cloud = read("1 2 3 0 0 1\n4 5 6 0 1 0\n");
  EXPECT_EQ(cloud.normals, (std::vector<Vec3>{{0, 0, 1}, {0, 1, 0}}));
  EXPECT_TRUE(cloud.colors.empty());
  cloud = read("1 2 3 0 0 1\n4 5 6 255 1 0\n");
  EXPECT_EQ(cloud.colors, (std::vector<Color>{{0, 0, 1}, {255, 1, 0}}));
  EXPECT_TRUE(cloud.normals.empty());
  cloud = read("1 2 3 0 0 1\n4 5 6 255 1 0.5\n");
  EXPECT_EQ(cloud.normals.size(), 2u);
  cloud = read("1 2 3 0 0 1\n4 5 6 256 1 0\n");
  EXPECT_EQ(cloud.normals.size(), 2u);
}

TEST_F(Xyz, OtherColumnsAreScalars) {
  const PointCloud cloud = read("1 2 3 4\n5 6 7 8\n");
  ASSERT_EQ(cloud.scalars.size(), 1u);
  EXPECT_EQ(cloud.scalars[0].name, "c3");
  EXPECT_EQ(cloud.scalars[0].values, (std::vector<double>{4, 8}));
  const PointCloud wide = read("1 2 3 4 5 6 7\n");
  ASSERT_EQ(wide.scalars.size(), 4u);
  EXPECT_EQ(wide.scalars[3].name, "c6");
  EXPECT_TRUE(wide.normals.empty());
}

TEST_F(Xyz, RowsThatAreNotFiniteAreKept) {
  EXPECT_EQ(read("1 2 3\nnan nan nan\n4 inf 6\n").size(), 3u);
}

TEST_F(Xyz, KittenHasUnitNormals) {
  GPSRECON_DATA_FILE(path, "scans/cgal_kitten.xyz");
  const PointCloud cloud = read_points(path.string());
  ASSERT_EQ(cloud.normals.size(), cloud.size());
  for (const Vec3& n : cloud.normals) EXPECT_NEAR(n.norm(), 1, 1e-4);
}

TEST(Text, Numbers) {
  double value = 0;
  for (const auto& [text, expected] : std::vector<std::pair<const char*, double>>{{"0", 0},
                                                                                  {"-0.5", -0.5},
                                                                                  {"+1.5", 1.5},
                                                                                  {".25", 0.25},
                                                                                  {"5.", 5},
                                                                                  {"1e3", 1000},
                                                                                  {"1E-2", 0.01},
                                                                                  {"INF", HUGE_VAL},
                                                                                  {"-inf", -HUGE_VAL},
                                                                                  {"+infinity", HUGE_VAL},
                                                                                  {"1e400", HUGE_VAL},
                                                                                  {"1e-400", 0}}) {
    EXPECT_TRUE(io::parse_number(text, value)) << text;
    EXPECT_EQ(value, expected) << text;
  }
  EXPECT_TRUE(io::parse_number("NaN", value));
  EXPECT_TRUE(std::isnan(value));
  for (const char* const text : {"", "+", "-", "+-1", "1.5x", "one", "1,5", "0x10", " 1", "1 ", ".", "e5", "--1"})
    EXPECT_FALSE(io::parse_number(text, value)) << text;
  std::int64_t integer = 0;
  EXPECT_TRUE(io::parse_integer("9007199254740993", integer));
  EXPECT_EQ(integer, 9007199254740993);  // beyond the integers of double
  EXPECT_TRUE(io::parse_integer("3.0", integer));
  EXPECT_EQ(integer, 3);
  for (const char* const text : {"", "3.5", "nan", "inf", "99999999999999999999", "three"})
    EXPECT_FALSE(io::parse_integer(text, integer)) << text;
}

TEST(Formats, ErrorsOfPaths) {
  const TemporaryFolder folder;
  const auto message = [](const std::string& path) { return message_of<InputError>([&] { read_points(path); }); };
  EXPECT_EQ(message(folder / "missing.ply"), (folder / "missing.ply") + ": cannot open: No such file or directory");
  EXPECT_EQ(message(folder.path().string()), folder.path().string() + ": is a directory, expected a file");
  EXPECT_EQ(message(""), ": cannot open: No such file or directory");
  EXPECT_EQ(message("/dev/null"), "/dev/null: is empty");
  EXPECT_THAT(message((folder / "missing") + "/a.ply"), HasSubstr("No such file or directory"));
  write_bytes(folder / "points.xyz", "1 2 3\n");
  EXPECT_THAT(message_of<InputError>([&] { read_mesh(folder / "points.xyz"); }),
              HasSubstr("expected a mesh (.ply .off"));
  EXPECT_THAT(message_of<InputError>([&] { read_mixture(folder / "points.xyz"); }),
              HasSubstr("expected a PLY file of Gaussians"));
  EXPECT_THAT(message_of<InputError>([&] { probe_file(folder / "missing.ply"); }), HasSubstr("cannot open"));
}

TEST(Formats, ProbeByExtension) {
  const TemporaryFolder folder;
  for (const auto& [name, bytes] : test::small_files()) {
    write_bytes(folder / name, bytes);
    const FileKind expected = name.starts_with("mixture")                          ? FileKind::mixture
                              : name.starts_with("covmesh")                        ? FileKind::covmesh
                              : name.starts_with("mesh") || name.ends_with(".stl") ? FileKind::mesh
                                                                                   : FileKind::points;
    EXPECT_EQ(probe_file(folder / name), expected) << name;
  }
}

#ifdef GPSRECON_HAS_PCD

class Pcd : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Encodings, Pcd, testing::Values("ascii", "binary", "binary_compressed"),
                         [](const auto& test_case) { return std::string(test_case.param); });

TEST_P(Pcd, DoublesColorsAndScalars) {
  const TemporaryFolder folder;
  write_bytes(folder / "points.pcd", test::pcd_file(GetParam()));
  const PointCloud cloud = read_points(folder / "points.pcd");
  EXPECT_EQ(cloud.positions, test::pcd_positions());
  EXPECT_EQ(cloud.colors, (std::vector<Color>{{1, 2, 3}, {2, 4, 6}, {3, 6, 9}}));
  ASSERT_EQ(cloud.scalars.size(), 1u);
  EXPECT_EQ(cloud.scalars[0].name, "label");
  EXPECT_EQ(cloud.scalars[0].values, (std::vector<double>{40000, 40001, 40002}));
  EXPECT_TRUE(cloud.sensors.empty());
}

TEST_P(Pcd, ViewpointIsTheSensor) {
  const TemporaryFolder folder;
  write_bytes(folder / "points.pcd", test::pcd_file(GetParam(), "637000.125 849000.3 1 1 0 0 0"));
  EXPECT_EQ(read_points(folder / "points.pcd").sensors, std::vector<Vec3>(3, Vec3(637000.125, 849000.3, 1)));
}

TEST(PcdFiles, FloatsNormalsAndMissingLines) {
  const TemporaryFolder folder;
  const std::string path = folder / "points.pcd";
  write_bytes(path,
              "VERSION .7\nFIELDS x y z normal_x normal_y normal_z curvature\nSIZE 4 4 4 4 4 4 4\nTYPE F F F F F F F\n"
              "COUNT 1 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3 0 0 1 0.5\nnan nan nan 0 1 0 0\n");
  const PointCloud cloud = read_points(path);
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.positions[0], Vec3(1, 2, 3));
  EXPECT_TRUE(std::isnan(cloud.positions[1].x()));
  EXPECT_EQ(cloud.normals, (std::vector<Vec3>{{0, 0, 1}, {0, 1, 0}}));
  EXPECT_EQ(cloud.scalars.at(0).name, "curvature");
}

TEST(PcdFiles, FieldsWithoutPositionsAreRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "points.pcd";
  write_bytes(path,
              "VERSION .7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2\n");
  EXPECT_EQ(message_of<InputError>([&] { read_points(path); }), path + ": expected fields 'x', 'y', 'z'");
}

// The plug-in is looked for where the environment says first; what lies there must be one.
TEST(PcdFiles, BrokenPluginNamesAConverter) {
  const TemporaryFolder folder;
  write_bytes(folder / "gpsrecon_pcd.so", "not a library");
  write_bytes(folder / "points.pcd", test::pcd_file("ascii"));
  const auto read = [&] {
    ::setenv("GPSRECON_PLUGIN_DIR", folder.path().c_str(), 1);
    std::fputs(message_of<InputError>([&] { read_points(folder / "points.pcd"); }).c_str(), stderr);
    std::exit(0);
  };
  EXPECT_EXIT(read(), testing::ExitedWithCode(0),
              "points.pcd: PCD files need a plug-in.*gpsrecon_pcd.so.*convert.*pcl_pcd2ply");
}

#endif

}  // namespace
}  // namespace gpsrecon
