#include <gpsrecon/core/face_geometry.h>

#include <gtest/gtest.h>
#include <array>
#include <numbers>
#include <vector>

#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

TEST(AreaVector, OfARegularPolygonIsItsAxisTimesTwiceItsArea) {
  test::Random random(1);
  for (const Index n : {3U, 4U, 7U}) {
    const Mat3 turn = random.rotation();
    const Vec3 center = 5 * random.vector();
    std::vector<Vec3> positions;
    std::vector<Index> face;
    for (Index k = 0; k < n; ++k) {
      const double angle = 2 * std::numbers::pi * k / n;
      positions.push_back(center + turn * Vec3(std::cos(angle), std::sin(angle), 0));
      face.push_back(k);
    }
    const double twice_area = n * std::sin(2 * std::numbers::pi / n);
    EXPECT_LT((area_vector(positions, face) - twice_area * turn.col(2)).norm(), 1e-13);
    EXPECT_LT((unit_normal(positions, face) - turn.col(2)).norm(), 1e-13);
    // The sum of p × q around the rim, and so the same from any corner.
    Vec3 around = Vec3::Zero();
    for (Index k = 0; k < n; ++k) around += positions[k].cross(positions[(k + 1) % n]);
    EXPECT_LT((area_vector(positions, face) - around).norm(), 1e-12);
  }
}

/// Of a closed surface the area vectors cancel, also where its quadrilaterals are bent.
TEST(AreaVector, SumsToZeroOverAClosedSurface) {
  test::Random random(2);
  const std::vector<Vec3> positions = random.vectors(8);
  const std::vector<std::array<Index, 4>> cube{{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                               {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  Vec3 sum = Vec3::Zero();
  for (const auto& face : cube) sum += area_vector(positions, face);
  EXPECT_LT(sum.norm(), 1e-14);
}

TEST(ForEachTriangle, VisitsTheFanInOrder) {
  std::vector<std::array<Index, 3>> fan;
  for_each_triangle(std::array<Index, 5>{9, 4, 6, 2, 0}, [&](Index a, Index b, Index c) { fan.push_back({a, b, c}); });
  EXPECT_EQ(fan, (std::vector<std::array<Index, 3>>{{9, 4, 6}, {9, 6, 2}, {9, 2, 0}}));
  for_each_triangle(std::array<Index, 2>{1, 2}, [](Index, Index, Index) { FAIL(); });
}

TEST(UnitNormal, OfNoAreaIsZeroAndOfATinyOneIsNot) {
  const std::vector<Vec3> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, tiny{{0, 0, 0}, {1e-120, 0, 0}, {0, 1e-120, 0}};
  const std::array<Index, 3> face{0, 1, 2};
  EXPECT_EQ(unit_normal(line, face), Vec3(Vec3::Zero()));
  EXPECT_EQ(unit_normal(tiny, face), Vec3(Vec3::UnitZ()));
}

}  // namespace
}  // namespace gpsrecon
