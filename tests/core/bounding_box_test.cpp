#include <gpsrecon/core/bounding_box.h>

#include <gtest/gtest.h>
#include <vector>

#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

TEST(BoundingBox, OfAnEllipsoidTouchesItsPoles) {
  const Vec3 center(10, -20, 30), radius(1, 2, 5);
  std::vector<Vec3> points;
  test::Random random(3);
  for (int i = 0; i < 200; ++i) points.push_back(center + radius.cwiseProduct(random.vector().normalized()));
  for (int k = 0; k < 3; ++k)
    for (const int side : {-1, 1}) points.push_back(center + side * radius[k] * Vec3::Unit(k));
  const Box3 box = bounding_box(points);
  EXPECT_EQ(box.min(), Vec3(center - radius));
  EXPECT_EQ(box.max(), Vec3(center + radius));
  EXPECT_DOUBLE_EQ(diagonal_length(bounding_box(points)), 2 * radius.norm());
}

TEST(BoundingBox, OfSomeIsThatOfASelection) {
  test::Random random(4);
  std::vector<Vec3> points, selected;
  for (int i = 0; i < 50; ++i) points.push_back(random.vector());
  const std::vector<Index> used{7, 3, 3, 41, 20};
  for (const Index i : used) selected.push_back(points[i]);
  EXPECT_TRUE(bounding_box(points, used).isApprox(bounding_box(selected), 0));
}

TEST(BoundingBox, OfNothingIsEmptyAndHasNoExtent) {
  EXPECT_TRUE(bounding_box({}).isEmpty());
  EXPECT_EQ(diagonal_length(bounding_box({})), 0);
  const std::vector<Vec3> one{Vec3(1, 2, 3)};
  EXPECT_EQ(diagonal_length(bounding_box(one)), 0);
  EXPECT_FALSE(bounding_box(one).isEmpty());
}

}  // namespace
}  // namespace gpsrecon
