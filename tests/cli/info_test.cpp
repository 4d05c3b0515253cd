#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "clouds.h"
#include "process.h"

namespace gpsrecon::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

TEST(Info, points_of_a_file) {
  TemporaryFolder folder;
  write_bytes(folder / "p.ply", ply_of({Vec3(1, 2, 3), Vec3(4, 6, 3), Vec3(NAN, 0, 0)}));
  const json info = json::parse(run({"info", folder / "p.ply", "--json"}).out).at(0);
  EXPECT_EQ(info.at("kind"), "points");
  EXPECT_EQ(info.at("points"), 3);
  EXPECT_EQ(info.at("non_finite"), 1);
  EXPECT_EQ(info.at("bbox_min"), json({1.0, 2.0, 3.0}));
  EXPECT_EQ(info.at("bbox_max"), json({4.0, 6.0, 3.0}));
  EXPECT_EQ(info.at("diagonal"), 5.0);
  EXPECT_THAT(run({"info", folder / "p.ply"}).out,
              AllOf(HasSubstr("kind"), HasSubstr("points"), HasSubstr("diagonal")));
}

TEST(Info, mesh_topology) {
  TemporaryFolder folder;
  // Two triangles that share an edge: one loop of four edges.
  write_bytes(folder / "m.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n");
  const json info = json::parse(run({"info", folder / "m.off", "--json"}).out).at(0);
  EXPECT_EQ(info.at("kind"), "mesh");
  const json& t = info.at("topology");
  EXPECT_EQ(t.at("faces"), 2);
  EXPECT_EQ(t.at("edges"), 5);
  EXPECT_EQ(t.at("euler"), 1);
  EXPECT_EQ(t.at("boundary_loops"), 1);
  EXPECT_EQ(t.at("boundary_edges"), 4);
  EXPECT_TRUE(t.at("manifold").get<bool>());
}

TEST(Info, several_files_and_standard_input) {
  TemporaryFolder folder;
  write_bytes(folder / "a.xyz", "0 0 0\n1 0 0\n");
  write_bytes(folder / "b.xyz", "0 0 0\n0 0 2\n0 1 0\n");
  const json all = json::parse(
      run({"info", "--json", folder / "a.xyz", folder / "b.xyz", "-"}, {.input = ply_of({Vec3(1, 1, 1)})}).out);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].at("points"), 2);
  EXPECT_EQ(all[1].at("points"), 3);
  EXPECT_EQ(all[2].at("points"), 1);
  EXPECT_EQ(all[2].at("file"), "-");
}

TEST(Info, a_file_that_cannot_be_read) {
  const ProcessResult result = run({"info", "/no/such.ply"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("/no/such.ply"));
  EXPECT_EQ(result.out, "");
}

}  // namespace
}  // namespace gpsrecon::test
