// Figures recomputed in double precision for two published demos: nine-column linear Loop subdivision with Warren's
// weights, mapped back at the end.

#include "support/covmeshes.h"

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/gps/subdivide.h>
#include <gtest/gtest.h>

#include "support/data_files.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

/// The vertices of a level themselves, by Warren's weights.
Mesh refined_vertices(const CovMesh& mesh, int levels) {
  return subdivide(with_rules(mesh, {.weights = LoopWeights::warren}), {.levels = levels, .limit = false});
}

struct Cone {
  std::string name;
  Sym3 apex;
  double apex_y_1, odd_x, odd_y, apex_y_5, area_5;
};

CovMesh cone_mesh(const Sym3& apex) {
  const double d = 1.41421;
  Mesh mesh = mesh_of({{0, 1.5, 0},
                       {d, -1.5, -d},
                       {0, -1.5, -2},
                       {-d, -1.5, -d},
                       {-2, -1.5, 0},
                       {-d, -1.5, d},
                       {0, -1.5, 2},
                       {d, -1.5, d},
                       {2, -1.5, 0}},
                      {});
  for (Index i = 1; i < 8; ++i) mesh.faces.add(0, i, i + 1);
  mesh.faces.add(0, 8, 1);
  CovMesh cone = with_equal_covariances(mesh, Sym3::identity(0.01));
  cone.vertices.covariances[0] = apex;
  return cone;
}

class Cones : public testing::TestWithParam<Cone> {};

TEST_P(Cones, AgreeWithTheGoldenValues) {
  const Cone& expected = GetParam();
  const CovMesh cone = cone_mesh(expected.apex);
  const Mesh once = refined_vertices(cone, 1);
  EXPECT_NEAR(once.positions[0].y(), expected.apex_y_1, 5e-7);
  // The vertex on the edge from the apex to vertex 8 is the only new one at z = 0, x > 0 off the base.
  std::size_t found = 0;
  for (std::size_t v = 9; v < once.positions.size(); ++v) {
    const Vec3& p = once.positions[v];
    if (std::abs(p.z()) > 1e-9 || p.x() < 0 || p.y() < -1.4) continue;
    ++found;
    EXPECT_NEAR(p.x(), expected.odd_x, 5e-7);
    EXPECT_NEAR(p.y(), expected.odd_y, 5e-7);
  }
  EXPECT_EQ(found, 1u);

  const Mesh five = refined_vertices(cone, 5);
  EXPECT_EQ(five.positions.size(), 4225u);
  EXPECT_EQ(five.faces.size(), 8192u);
  EXPECT_NEAR(five.positions[0].y(), expected.apex_y_5, 5e-7);
  EXPECT_NEAR(area(five), expected.area_5, 5e-7);
}

INSTANTIATE_TEST_SUITE_P(
    Golden, Cones,
    testing::Values(Cone{"iso", Sym3::identity(0.01), 0.375, 1.103552, -0.375, 0.001465, 15.457877},
                    Cone{"pointy", Sym3::identity(1e-5), 1.498201, 0.002938, 1.495008, 1.497009, 19.834398},
                    Cone{"concave", Sym3::diagonal(1e-3, 1e-2, 1e-2), 0.375, 0.252241, -0.375, 0.001465, 13.969139},
                    Cone{"plateau", Sym3::diagonal(1e-2, 1e-3, 1e-2), 1.330189, 1.103552, 1.071429, 1.227757,
                         30.357188},
                    Cone{"cylinder", Sym3::diagonal(1, 1e-5, 1), 1.498201, 1.755153, 1.495008, 1.497009, 43.621992}),
    [](const auto& cone) { return cone.param.name; });

TEST(Tweety, AgreesWithTheGoldenValues) {
  GPSRECON_DATA_FILE(path, "meshes/tweety.off");
  const Mesh tweety = read_plain_off(path);
  ASSERT_EQ(tweety.positions.size(), 192u);
  EXPECT_NEAR(volume(tweety), 0.116727, 5e-7);
  EXPECT_NEAR(area(tweety), 1.796656, 5e-7);

  const Inference inferred = infer_covariances(tweety);
  EXPECT_EQ(inferred.degenerate_faces, 0u);
  const CovMesh linear = with_equal_covariances(tweety, Sym3::identity());
  struct Row {
    std::size_t vertices;
    double gps_volume, gps_area, loop_volume, loop_area;
  };
  const std::array<Row, 4> rows{{{762, 0.132449, 1.830020, 0.110888, 1.626750},
                                 {3042, 0.136251, 1.836324, 0.109545, 1.591927},
                                 {12162, 0.137160, 1.838006, 0.109216, 1.583763},
                                 {48642, 0.137384, 1.838426, 0.109135, 1.581758}}};
  for (int level = 1; level <= 4; ++level) {
    SCOPED_TRACE(level);
    const Row& row = rows[static_cast<std::size_t>(level - 1)];
    const Mesh gps = refined_vertices(inferred.mesh, level);
    const Mesh loop = refined_vertices(linear, level);
    EXPECT_EQ(gps.positions.size(), row.vertices);
    EXPECT_NEAR(volume(gps), row.gps_volume, 6e-7);
    EXPECT_NEAR(area(gps), row.gps_area, 6e-7);
    EXPECT_NEAR(volume(loop), row.loop_volume, 6e-7);
    EXPECT_NEAR(area(loop), row.loop_area, 6e-7);
    if (level == 1) {
      EXPECT_LT((gps.positions[0] - Vec3(0.431410, -0.086996, 0.073422)).cwiseAbs().maxCoeff(), 6e-7);
      EXPECT_LT((loop.positions[0] - Vec3(0.404314, -0.087722, 0.100328)).cwiseAbs().maxCoeff(), 6e-7);
    }
    if (level == 4) {
      const Box3 box = bounding_box(gps.positions);
      EXPECT_LT((box.min() - Vec3(-0.351876, -0.412504, -0.366992)).cwiseAbs().maxCoeff(), 6e-7);
      EXPECT_LT((box.max() - Vec3(0.506758, 0.570337, 0.350779)).cwiseAbs().maxCoeff(), 6e-7);
      const Topology t = topology(gps.faces, gps.positions.size());
      EXPECT_TRUE(t.manifold());
      EXPECT_EQ(t.euler, 2);
      EXPECT_EQ(t.boundary_loops, 0u);
    }
  }
}

}  // namespace
}  // namespace gpsrecon::test
