#include <gtest/gtest.h>

#include <gpsrecon/clop/normals.h>
#include <gpsrecon/clop/orientation.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/scan/gallery.h>
#include <gpsrecon/scan/virtual_scan.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::joined;
using test::Random;
using test::SampledShape;

SampledShape scanned(const std::string& name, std::size_t points) {
  const VirtualScan scan = virtual_scan(*make_shape(name), {.points = points});
  SampledShape shape;
  shape.points = scan.cloud.positions;
  shape.normals = scan.cloud.normals;
  return shape;
}

std::vector<Vec3> with_random_signs(std::vector<Vec3> normals, std::uint64_t seed) {
  Random random(seed);
  for (Vec3& n : normals)
    if (random.uniform() < 0.5) n = -n;
  return normals;
}

/// Number of normals that do not point outward.
std::size_t turned_in(const std::vector<Vec3>& normals, const SampledShape& shape) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) count += normals[i].dot(shape.normals[i]) > 0 ? 0 : 1;
  return count;
}

TEST(Propagation, turns_closed_surfaces_outward) {
  const SampledShape nested = joined(test::random_sphere(3000, 1), test::random_sphere(1500, 2, 0.6));
  const std::tuple<const char*, SampledShape, std::size_t> shapes[] = {
      {"sphere", test::random_sphere(3000, 1), 1},
      {"torus", test::torus(3000, 1, 0.4), 1},
      {"nested spheres", nested, 2},
      {"knot", scanned("knot", 12000), 1},
      {"gyroid", scanned("gyroid", 20000), 1},
      {"box", test::box(6000, {1, 0.7, 0.4}, 3), 1},
      {"two spheres", joined(test::random_sphere(900, 4), test::random_sphere(1500, 5, 2, {9, 1, 2})), 2},
  };
  for (const auto& [name, shape, parts] : shapes) {
    std::vector<Vec3> normals = with_random_signs(shape.normals, 7);
    EXPECT_EQ(orient_by_propagation(normals, shape.points), parts) << name;
    EXPECT_EQ(turned_in(normals, shape), 0u) << name;
    // Estimated ones, which planes across edges and rims round off.
    std::vector<Vec3> estimated = with_random_signs(pca_normals(shape.points, shape.points), 8);
    orient_by_propagation(estimated, shape.points);
    EXPECT_LE(turned_in(estimated, shape), shape.points.size() / 1000) << name;
  }
}

TEST(Propagation, follows_a_circle_of_few_points_around) {
  // Five normals, 72° apart, each in its neighbour's half space only by the mirror; two layers make them a surface.
  std::vector<Vec3> positions, truth;
  for (int i = 0; i < 10; ++i) {
    const double turn = 2 * std::numbers::pi * (i % 5) / 5;
    truth.emplace_back(std::cos(turn), std::sin(turn), 0);
    positions.push_back(truth.back() + (i < 5 ? 0 : 0.5) * Vec3::UnitZ());
  }
  std::vector<Vec3> normals = with_random_signs(truth, 3);
  orient_by_propagation(normals, positions, {.neighbors = 3});
  for (std::size_t i = 0; i < normals.size(); ++i) EXPECT_EQ(normals[i], truth[i]) << i;
}

TEST(Propagation, is_not_misled_by_outliers) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SampledShape sphere = test::random_sphere(3000, seed);
    test::add_noise(sphere, 0.02, seed + 10);
    Random random(seed + 20);
    for (int i = 0; i < 60; ++i) {
      sphere.points.push_back(random.uniform(1.3, 4) * random.direction());
      sphere.normals.push_back(random.direction());
    }
    std::vector<Vec3> normals = pca_normals(sphere.points, sphere.points);
    orient_by_propagation(normals, sphere.points);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < 3000; ++i) wrong += normals[i].dot(sphere.normals[i]) > 0 ? 0 : 1;
    EXPECT_LT(wrong, 15u) << seed;
  }
}

TEST(Propagation, turns_open_sheets_up) {
  for (const double sign : {-1, 1}) {
    std::vector<Vec3> positions, normals;
    Random random(1);
    for (int i = 0; i < 3000; ++i) {
      const double x = random.uniform(0, 10), y = random.uniform(0, 10);
      positions.emplace_back(x, y, 0.3 * std::sin(x) * std::cos(y));
      normals.push_back(sign * Vec3(-0.3 * std::cos(x) * std::cos(y), 0.3 * std::sin(x) * std::sin(y), 1).normalized());
    }
    EXPECT_EQ(orient_by_propagation(normals, positions), 1u);
    for (const Vec3& n : normals) EXPECT_GT(n.z(), 0);
  }
}

TEST(Propagation, does_not_depend_on_signs_or_threads) {
  const SampledShape shape = test::torus(5000, 1, 0.4);
  std::vector<Vec3> first = pca_normals(shape.points, shape.points);
  std::vector<Vec3> second = with_random_signs(first, 1);
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  orient_by_propagation(first, shape.points, {}, one);
  orient_by_propagation(second, shape.points, {}, four);
  EXPECT_EQ(first, second);
}

TEST(Propagation, of_degenerate_clouds) {
  std::vector<Vec3> none;
  EXPECT_EQ(orient_by_propagation(none, {}), 0u);
  std::vector<Vec3> single{Vec3::UnitX()};
  EXPECT_EQ(orient_by_propagation(single, std::vector<Vec3>{Vec3::Zero()}), 1u);
  EXPECT_EQ(std::abs(single[0].x()), 1.0);
  std::vector<Vec3> equal(50, Vec3::UnitZ());
  equal[3] = -equal[3];
  orient_by_propagation(equal, std::vector<Vec3>(50, Vec3::Ones()));
  for (const Vec3& n : equal) EXPECT_EQ(n, equal[0]);
  EXPECT_THROW(orient_by_propagation(equal, std::vector<Vec3>(49)), InvariantError);
  EXPECT_THROW(orient_by_propagation(equal, std::vector<Vec3>(50), {.neighbors = 0}), OptionError);
}

TEST(OrientAlong, turns_to_the_side_of_the_sensor) {
  const SampledShape sphere = test::random_sphere(500, 1);
  const Vec3 sensor(0, 0, 3);
  std::vector<Vec3> normals = with_random_signs(sphere.normals, 2), ways;
  for (const Vec3& p : sphere.points) ways.push_back(sensor - p);
  orient_along(normals, ways);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    EXPECT_GE(normals[i].dot(ways[i]), 0);
    // What the sensor sees is outward: the cap above z = 1/3.
    if (sphere.points[i].z() > 1.0 / 3) {
      EXPECT_GT(normals[i].dot(sphere.normals[i]), 0);
    }
  }
  EXPECT_THROW(orient_along(normals, std::vector<Vec3>(3)), InvariantError);
}

}  // namespace
}  // namespace gpsrecon
