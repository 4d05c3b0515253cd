#include <gpsrecon/core/principal_axes.h>

#include <gtest/gtest.h>
#include <vector>

#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

std::vector<Neighbor> all_of(std::size_t n) {
  std::vector<Neighbor> near;
  for (Index i = 0; i < n; ++i) near.push_back({i, 0});
  return near;
}

/// Pairs at ± a_k along orthogonal axes have the covariance Σ a_k² u_k u_kᵀ / 3 about any place.
TEST(LocalCovariance, OfPairsOnOrthogonalAxes) {
  const Mat3 axes = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.4).normalized().toRotationMatrix();
  const Vec3 extent(0.5, 1, 2), center(3, 4, 5);
  std::vector<Vec3> points;
  for (int k = 0; k < 3; ++k)
    for (const int side : {-1, 1}) points.push_back(center + side * extent[k] * axes.col(k));
  const Mat3 expected = axes * (extent.cwiseAbs2() / 3).asDiagonal() * axes.transpose();
  const Sym3 covariance = local_covariance(points, points[2], all_of(points.size()));
  EXPECT_LT((covariance.matrix() - expected).norm(), 1e-14);
  EXPECT_LT((scatter(points).matrix() - 6 * expected).norm(), 1e-13);
}

TEST(LocalCovariance, CountsOnlyTheNeighboursAndNoOffset) {
  test::Random random(2);
  std::vector<Vec3> points;
  for (int i = 0; i < 40; ++i) points.push_back(random.vector());
  const std::vector<Neighbor> near{{4, 0}, {9, 0}, {11, 0}, {30, 0}, {31, 0}};
  Mat3 expected = Mat3::Zero();  // half the mean of the squared differences of all pairs
  for (const Neighbor& a : near)
    for (const Neighbor& b : near)
      expected += (points[a.index] - points[b.index]) * (points[a.index] - points[b.index]).transpose() / 50;
  EXPECT_LT((local_covariance(points, points[4], near).matrix() - expected).norm(), 1e-15);
  // A place 2^30 away costs what the coordinates lose, 2^-22 or less each.
  for (Vec3& p : points) p += Vec3::Constant(std::ldexp(1.0, 30));
  EXPECT_LT((local_covariance(points, points[4], near).matrix() - expected).norm(), 16 * std::ldexp(1.0, -22));
}

TEST(OnALine, TellsAHairFromNothing) {
  const Vec3 origin(1, 2, 3), along = Vec3(2, -1, 0.5).normalized(), across = along.unitOrthogonal();
  const auto line = [&](double width) {
    std::vector<Vec3> points;
    for (int i = 0; i < 100; ++i) points.push_back(origin + i * along + (i % 2 == 0 ? width : -width) * across);
    return points;
  };
  EXPECT_TRUE(on_a_line(line(0)));
  EXPECT_TRUE(on_a_line(line(1e-9)));  // 50 to either side of the mean
  EXPECT_FALSE(on_a_line(line(1e-6)));
  EXPECT_TRUE(on_a_line(std::vector<Vec3>(5, origin)));
}

}  // namespace
}  // namespace gpsrecon
