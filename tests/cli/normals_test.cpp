#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/io/io.h>
#include <gpsrecon/report/file_hash.h>
#include <cmath>

#include "clouds.h"
#include "process.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

class Normals : public testing::Test {
 protected:
  TemporaryFolder folder;
  std::string path(const std::string& name) const { return folder / name; }
  ProcessResult program(const std::string& arguments) const {
    return run(words_of(arguments), {.folder = folder.path().string()});
  }
  void succeed(const std::string& arguments) const {
    const ProcessResult result = program(arguments);
    ASSERT_EQ(result.exit_code, 0) << arguments << "\n" << result.err;
    EXPECT_THAT(result.out, IsEmpty());
  }
  void fail(const std::string& arguments, int code, const std::string& message) const {
    const auto before = names_in(folder);
    const ProcessResult result = program(arguments);
    EXPECT_EQ(result.exit_code, code) << arguments << "\n" << result.err;
    EXPECT_THAT(result.err, HasSubstr(message)) << arguments;
    EXPECT_EQ(names_in(folder), before);
  }
  /// Share of the normals within 20° of the outward ones of the unit sphere.
  double share_outward(const std::string& name, const Vec3& center = Vec3::Zero()) const {
    const PointCloud cloud = read_points(path(name));
    EXPECT_EQ(cloud.normals.size(), cloud.size());
    double count = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      count += cloud.normals[i].dot((cloud.positions[i] - center).normalized()) > std::cos(0.35) ? 1 : 0;
    return count / static_cast<double>(cloud.size());
  }
};

TEST_F(Normals, of_every_method_point_out_of_a_sphere) {
  write_bytes(path("in.ply"), ply_of(noisy_sphere(4000, 0.005)));
  for (const std::string method : {"pca", "weiszfeld", "csw"}) {
    succeed("normals in.ply out.ply --method " + method);
    EXPECT_EQ(share_outward("out.ply"), 1) << method;
  }
  succeed("mixture in.ply m.ply --normals");
  EXPECT_EQ(read_mixture(path("m.ply")).normals.size(), read_mixture(path("m.ply")).size());
  succeed("normals in.ply two.ply --method csw --mixture m.ply");
  EXPECT_EQ(share_outward("two.ply"), 1);
}

TEST_F(Normals, leave_everything_else_as_it_was) {
  // Far from the origin, with colours, scalars, sensors and old normals, a row that is not finite and an equal one.
  PointCloud cloud;
  const std::vector<Vec3> sphere = noisy_sphere(500, 0);
  for (std::size_t i = 0; i < 500; ++i) {
    cloud.positions.push_back(Vec3(612345.125, 5123456.75, 100) + sphere[i]);
    cloud.normals.push_back(Vec3::UnitX());
    cloud.sensors.push_back(cloud.positions[i] + 3 * sphere[i]);
    cloud.colors.push_back({static_cast<std::uint8_t>(i % 256), 7, 9});
  }
  cloud.scalars.push_back({"intensity", std::vector<double>(500, 0.1), ScalarKind::quantity});
  for (std::size_t i = 0; i < 500; ++i) cloud.scalars[0].values[i] += static_cast<double>(i);
  cloud.positions[20] = cloud.positions[10];
  cloud.positions[30].y() = std::nan("");
  write_points(cloud, path("in.ply"));
  succeed("normals in.ply out.ply");
  const PointCloud out = read_points(path("out.ply"));
  ASSERT_EQ(out.size(), 499u);
  for (std::size_t i = 0; i < 499; ++i) {
    const std::size_t from = i < 30 ? i : i + 1;
    EXPECT_EQ(out.positions[i], cloud.positions[from]);
    EXPECT_EQ(out.sensors[i], cloud.sensors[from]);
    EXPECT_EQ(out.colors[i], cloud.colors[from]);
    EXPECT_EQ(out.scalars[0].values[i], cloud.scalars[0].values[from]);
    EXPECT_NEAR(out.normals[i].norm(), 1, 1e-12);
  }
  EXPECT_EQ(out.normals[20], out.normals[10]);
  EXPECT_EQ(share_outward("out.ply", {612345.125, 5123456.75, 100}), 1);  // the sensors are outside
}

TEST_F(Normals, take_their_side_from_sensor_surface_or_neighbours) {
  write_bytes(path("in.ply"), ply_of(noisy_sphere(3000, 0)));
  // From the centre all normals are seen from the inner side.
  succeed("normals in.ply inward.ply --sensor 0,0,0");
  EXPECT_EQ(share_outward("inward.ply"), 0);
  // So they are on an octahedron turned inside out.
  write_bytes(path("inside-out.off"),
              "OFF\n6 8 0\n1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n"
              "3 2 0 4\n3 1 2 4\n3 3 1 4\n3 0 3 4\n3 0 2 5\n3 2 1 5\n3 1 3 5\n3 3 0 5\n");
  succeed("normals in.ply by-surface.ply --surface inside-out.off");
  EXPECT_EQ(share_outward("by-surface.ply"), 0);
  succeed("normals in.ply by-neighbours.ply --orient mst --sensor 0,0,0");
  EXPECT_EQ(share_outward("by-neighbours.ply"), 1);
  succeed("normals in.ply no.ply --orient none");
  EXPECT_GT(share_outward("no.ply"), 0.1);
  EXPECT_LT(share_outward("no.ply"), 0.9);
}

TEST_F(Normals, are_the_same_bytes_for_any_number_of_threads) {
  write_bytes(path("in.ply"), ply_of(noisy_torus(6000, 0.01)));
  for (const std::string method : {"pca", "weiszfeld", "csw"}) {
    succeed("normals in.ply one.ply --threads 1 --method " + method);
    succeed("normals in.ply four.ply --threads 4 --method " + method);
    EXPECT_EQ(hash_file(path("one.ply")), hash_file(path("four.ply"))) << method;
  }
}

TEST_F(Normals, are_refused_where_there_are_none) {
  write_bytes(path("one.xyz"), "1 2 3\n");
  write_bytes(path("line.xyz"), "0 0 0\n1 2 3\n2 4 6\n3 6 9\n");
  write_bytes(path("same.xyz"), "1 2 3\n1 2 3\n1 2 3\n1 2 3\n");
  write_bytes(path("nan.xyz"), "nan 0 0\n");
  write_bytes(path("sphere.ply"), ply_of(noisy_sphere(1000, 0)));
  write_bytes(path("points.off"), "OFF\n1 0 0\n0 0 0\n");
  succeed("mixture sphere.ply m.ply");
  for (const std::string method : {"pca", "weiszfeld", "csw"}) {
    fail("normals one.xyz out.ply --method " + method, 4, "one.xyz");
    fail("normals line.xyz out.ply --method " + method, 4, "line.xyz");
    fail("normals same.xyz out.ply --method " + method, 4, "same.xyz");
    fail("normals nan.xyz out.ply --method " + method, 3, "nan.xyz");
  }
  fail("normals sphere.ply out.ply --method csw --mixture m.ply", 3, "m.ply: the mixture has no normals");
  fail("normals sphere.ply out.ply --surface points.off", 3, "points.off: holds no faces");
  fail("normals sphere.ply out.obj", 6, ".ply");
}

TEST_F(Normals, of_three_points_are_those_of_their_plane) {
  write_bytes(path("in.xyz"), "0 0 5\n1 0 5\n0 1 5\n");
  for (const std::string method : {"pca", "weiszfeld"}) {
    succeed("normals in.xyz out.ply --method " + method + " --sensor 0,0,9");
    for (const Vec3& n : read_points(path("out.ply")).normals) EXPECT_LT((n - Vec3::UnitZ()).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace gpsrecon::test
