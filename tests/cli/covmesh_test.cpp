// `infer` and `covmesh`: from an ordinary mesh to an edited covariance mesh and out again.

#include <gmock/gmock.h>
#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/io/io.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "process.h"

namespace gpsrecon::test {
namespace {

using testing::HasSubstr;

class Covmesh : public testing::Test {
 protected:
  /// A cube from 0 to 1 of six quads.
  Covmesh() {
    std::ofstream file(folder_ / "cube.obj");
    for (int k = 0; k < 8; ++k) file << "v " << (k & 1) << ' ' << (k >> 1 & 1) << ' ' << (k >> 2 & 1) << '\n';
    file << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    file.close();
    EXPECT_EQ(run_in({"infer", "cube.obj", "cube.ply"}).exit_code, 0);
  }

  ProcessResult run_in(const std::vector<std::string>& arguments) const {
    return run(arguments, {.folder = folder_.path().string()});
  }

  /// The covariances after `steps` on the cube.
  std::vector<Sym3> edited(std::vector<std::string> steps) const {
    steps.insert(steps.begin(), {"covmesh", "cube.ply", "edited.ply"});
    const ProcessResult result = run_in(steps);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const CovMesh mesh = read_covmesh(folder_ / "edited.ply");
    validate(mesh);
    return mesh.vertices.covariances;
  }

  void expect_refused(std::vector<std::string> arguments, const std::string& message) const {
    arguments.insert(arguments.begin(), {"covmesh", "cube.ply", "refused.ply"});
    const ProcessResult result = run_in(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr(message));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "refused.ply"));
  }

  const TemporaryFolder folder_;
};

TEST_F(Covmesh, InfersFromPolygons) {
  const CovMesh cube = read_covmesh(folder_ / "cube.ply");
  EXPECT_EQ(cube.faces, read_mesh(folder_ / "cube.obj").faces);
  // Three sides at right angles, each with a variance of 1/4 along its edges and 5 % of it added.
  const double variance = 1 / (2 / (0.25 * 1.05) + 1 / (0.25 * 0.05));
  for (const Sym3& c : cube.vertices.covariances) EXPECT_LT((c.matrix() - variance * Mat3::Identity()).norm(), 1e-15);
  // σ0 in the unit of the coordinates is the same bias: 5 % of 1/4.
  const ProcessResult absolute = run_in({"infer", "cube.obj", "absolute.ply", "--sigma0", "0.11180339887498949"});
  EXPECT_EQ(absolute.exit_code, 0);
  EXPECT_THAT(absolute.err, HasSubstr("infer: 8 Gaussians, 0 degenerate faces"));
  for (const Sym3& c : read_covmesh(folder_ / "absolute.ply").vertices.covariances)
    EXPECT_LT((c.matrix() - variance * Mat3::Identity()).norm(), 1e-15);
  // Vertex and its three neighbours: offsets of 1 along each axis, mean 1/4.
  EXPECT_EQ(run_in({"infer", "cube.obj", "vertex.ply", "--method", "vertex", "--bias", "1e-9"}).exit_code, 0);
  const Sym3 c = read_covmesh(folder_ / "vertex.ply").vertices.covariances[0];
  EXPECT_NEAR(c.xx, 0.1875, 1e-9);
  EXPECT_NEAR(c.xy, -0.0625, 1e-9);
}

TEST_F(Covmesh, InferenceCountsWhatHasNoArea) {
  std::ofstream(folder_ / "needle.off")
      << "OFF\n5 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0 0\n3 0 1 2\n3 0 2 3\n3 1 0 4\n";
  const ProcessResult result = run_in({"infer", "needle.off", "needle.ply"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("infer: 5 Gaussians, 1 degenerate faces, 1 vertices without a proper face"));
  EXPECT_THAT(result.err, HasSubstr("warning: needle.off: 1 faces have no area"));
  validate(read_covmesh(folder_ / "needle.ply"));
}

TEST_F(Covmesh, InferenceRefuses) {
  std::ofstream(folder_ / "flat.off") << "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n";
  const ProcessResult flat = run_in({"infer", "flat.off", "out.ply"});
  EXPECT_EQ(flat.exit_code, 4);
  EXPECT_THAT(flat.err, HasSubstr("flat.off: infer: the mesh has no face with an area"));
  std::ofstream(folder_ / "tie.off") << "OFF\n5 2 0\n0 0 0\n1 0 0\n0 1 0\n-1 0 0\n0 -1 0\n3 0 1 2\n3 0 3 4\n";
  const ProcessResult tie = run_in({"infer", "tie.off", "out.ply"});
  EXPECT_EQ(tie.exit_code, 3);
  EXPECT_THAT(tie.err, HasSubstr("tie.off: "));
  EXPECT_EQ(run_in({"infer", "cube.obj", "out.ply", "--bias", "0"}).exit_code, 2);
  EXPECT_EQ(run_in({"infer", "cube.obj", "out.ply", "--sigma0", "-1"}).exit_code, 2);
  const ProcessResult both = run_in({"infer", "cube.obj", "out.ply", "--bias", "0.1", "--sigma0", "1"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.err, HasSubstr("bias and sigma0 contradict each other"));
  EXPECT_EQ(run_in({"infer", "cube.obj", "out.obj"}).exit_code, 6);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.ply"));
}

TEST_F(Covmesh, StepsActInTheOrderOfTheCommandLine) {
  const std::vector<Sym3> original = read_covmesh(folder_ / "cube.ply").vertices.covariances;
  const auto ends_as = [&](const std::vector<std::string>& steps, const auto& expected) {
    const std::vector<Sym3> covariances = edited(steps);
    for (std::size_t v = 0; v < original.size(); ++v)
      EXPECT_LT((covariances[v].matrix() - expected(v, original[v]).matrix()).norm(), 1e-14) << v;
  };
  ends_as({}, [](std::size_t, const Sym3& c) { return c; });
  ends_as({"--scale", "4", "--smooth", "1"}, [](std::size_t, const Sym3& c) { return 4 * c + Sym3::identity(); });
  ends_as({"--smooth", "1", "--scale", "4"}, [](std::size_t, const Sym3& c) { return 4 * (c + Sym3::identity()); });
  ends_as({"--scale=2", "--smooth=1", "--scale=3"},
          [](std::size_t, const Sym3& c) { return 3 * (2 * c + Sym3::identity()); });
  ends_as({"--select",  "2,4-5",
           "--scale",   "2",
           "--select",  "plane:0.5,0,0,-1,0,0",
           "--smooth",  "1,2,3",
           "--select",  "nearest:2:1,1,1.1",
           "--set",     "1,0,0,2,0,3",
           "--select",  "box:0.5,0,0,1,1,0.5",
           "--sharpen", "10:0.5",
           "--select",  "all",
           "--scale",   "0.5"},
          [](std::size_t v, Sym3 c) {
            if (v == 2 || v == 4 || v == 5) c *= 2;
            if (v % 2 == 0) c += Sym3::diagonal(1, 4, 9);
            // The nearest to (1, 1, 1.1) is vertex 7; 5 and 6 are equally far next.
            if (v == 7 || v == 5) c = Sym3::diagonal(1, 2, 3);
            if (v == 1 || v == 3) c = Sym3::identity(0.5 * eigen_decomposition(c).values[2]);
            return 0.5 * c;
          });
}

TEST_F(Covmesh, FlattensAlongAxes) {
  const std::vector<Sym3> given = edited({"--set", "1,2,3", "--flatten", "0,0,-5:0.01"});
  for (const Sym3& c : given) EXPECT_LT((c.matrix() - Sym3::diagonal(1, 4, 0.09).matrix()).norm(), 1e-14);
  const std::vector<Sym3> smallest =
      edited({"--set", "1,2,3", "--flatten", "smallest:0.5", "--flatten", "largest:2", "--flatten", "middle:0.25"});
  for (const Sym3& c : smallest) EXPECT_LT((c.matrix() - Sym3::diagonal(0.5, 1, 18).matrix()).norm(), 1e-13);
  // Balls have no smallest axis of their own.
  const ProcessResult ball = run_in({"covmesh", "cube.ply", "out.ply", "--set", "1", "--flatten", "smallest:0.5"});
  EXPECT_THAT(ball.err, HasSubstr("warning: step 2 (flatten): 8 covariances are as wide along another axis"));
}

TEST_F(Covmesh, RefusesBadSteps) {
  expect_refused({"--scale", "0"}, "--scale: ");
  expect_refused({"--scale", "nan"}, "--scale: expected a number");
  expect_refused({"--select", "8", "--scale", "2"}, "there is no vertex 8 among 8");
  expect_refused({"--select", "0,", "--scale", "2"}, "--select: expected all, indices");
  expect_refused({"--select", "5-3", "--scale", "2"}, "--select: expected all, indices");
  expect_refused({"--select", "ball:1", "--scale", "2"}, "--select: expected all, indices");
  expect_refused({"--select", "box:0,0,0,1,1", "--scale", "2"}, "--select: expected box:X0,Y0,Z0,X1,Y1,Z1");
  expect_refused({"--select", "box:0,0,1,1,1,0", "--scale", "2"}, "--select: select box: ");
  expect_refused({"--select", "box:5,5,5,6,6,6", "--scale", "2"}, "there is no vertex in it");
  expect_refused({"--select", "plane:0,0,0,0,0,0", "--scale", "2"}, "--select: select plane: normal: ");
  expect_refused({"--select", "nearest:0:0,0,0", "--scale", "2"}, "--select: select nearest: count: ");
  expect_refused({"--select", "nearest:0,0", "--scale", "2"}, "--select: expected three numbers");
  expect_refused({"--scale", "2", "--select", "1"}, "--select: no step follows");
  expect_refused({"--flatten", "0.1"}, "--flatten: expected AXIS:X");
  expect_refused({"--flatten", "big:0.1"}, "--flatten: expected three numbers");
  expect_refused({"--flatten", "0,0,0:0.1"}, "--flatten: flatten: direction: ");
  expect_refused({"--smooth", "-1"}, "--smooth: expected standard deviations that are not negative");
  expect_refused({"--smooth", "1,2"}, "--smooth: expected S, SX,SY,SZ");
  expect_refused({"--sharpen", "1:7"}, "--sharpen: sharpen: floor: ");
  expect_refused({"--set", "1,5,0,1,0,1"}, "--set: set: covariance: ");
  expect_refused({"--select", "0-4000000000", "--scale", "2"}, "there is no vertex 4000000000 among 8");
  expect_refused({"--select", "0-5000000000", "--scale", "2"}, "--select: expected all, indices");
  // The order of steps means something, and a configuration file has none.
  std::ofstream(folder_ / "steps.toml") << "scale = 2\n";
  expect_refused({"--config", "steps.toml"}, "unknown option 'scale'");
}

TEST_F(Covmesh, ExportsTheControlMesh) {
  for (const std::string name : {"control.obj", "control.off", "control.stl", "control.glb"}) {
    const ProcessResult result = run_in({"covmesh", "cube.ply", name});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_THAT(result.err, HasSubstr("no place for covariances"));
    EXPECT_TRUE(std::filesystem::exists(folder_ / name));
  }
  const Mesh cube = read_mesh(folder_ / "cube.obj"), control = read_mesh(folder_ / "control.obj");
  EXPECT_EQ(control.positions, cube.positions);
  EXPECT_EQ(control.faces, cube.faces);
  EXPECT_EQ(run_in({"covmesh", "cube.obj", "out.ply"}).exit_code, 3);
  EXPECT_EQ(run_in({"covmesh", "cube.ply", "out.xyz"}).exit_code, 6);
}

TEST_F(Covmesh, EveryMeshMayBeBinaryGltf) {
  std::ofstream(folder_ / "tetra.off")
      << "OFF\n4 4 0\n1 1 1\n1 -1 -1\n-1 1 -1\n-1 -1 1\n3 0 1 2\n3 0 2 3\n3 0 3 1\n3 1 3 2\n";
  EXPECT_EQ(run_in({"infer", "tetra.off", "tetra.ply"}).exit_code, 0);
  const std::vector<std::vector<std::string>> commands{
      {"subdivide", "tetra.ply", "out.glb", "--levels", "1"},
      {"tetra.ply", "out.glb", "--no-covmesh", "--no-report"},
      {"mixture", "tetra.ply", "mixture.ply", "--ellipsoids", "out.glb"},
      {"scan", "shape:sphere", "scan.ply", "--points", "100", "--truth", "out.glb", "--truth-tolerance", "1%"}};
  for (const auto& command : commands) {
    const ProcessResult result = run_in(command);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    std::ifstream file(folder_ / "out.glb", std::ios::binary);
    std::string magic(4, ' ');
    file.read(magic.data(), 4);
    EXPECT_EQ(magic, "glTF");
    file.close();
    std::filesystem::remove(folder_ / "out.glb");
  }
}

}  // namespace
}  // namespace gpsrecon::test
