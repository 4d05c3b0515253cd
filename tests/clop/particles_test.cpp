#include <gtest/gtest.h>

#include <gpsrecon/clop/particles.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/neighbors.h>
#include <algorithm>
#include <set>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;

std::set<std::array<double, 3>> places(const PointCloud& cloud) {
  std::set<std::array<double, 3>> all;
  for (const Vec3& p : cloud.positions) all.insert({p.x(), p.y(), p.z()});
  return all;
}

double smallest_distance(const PointCloud& cloud) {
  const Neighbors index(cloud.positions);
  std::vector<Neighbor> near;
  double smallest = std::numeric_limits<double>::infinity();
  for (const Vec3& p : cloud.positions) {
    index.nearest(p, 2, near);
    smallest = std::min(smallest, near[1].distance);
  }
  return smallest;
}

TEST(Particles, SubsetsAreDistinctPointsInOrderAndOfTheNumberAskedFor) {
  PointCloud points = test::random_sphere(1000, 3).cloud();
  for (std::size_t i = 0; i < points.size(); ++i) points.colors.push_back({static_cast<std::uint8_t>(i % 251), 0, 0});
  for (const ParticleSelection selection : {ParticleSelection::random, ParticleSelection::uniform})
    for (const std::size_t count : {1u, 2u, 77u, 999u}) {
      const PointCloud particles = choose_particles(points, {.particles = {.count = count}, .selection = selection});
      ASSERT_EQ(particles.size(), count);
      std::size_t at = 0;
      for (std::size_t i = 0; i < count; ++i) {
        while (at < points.size() && points.positions[at] != particles.positions[i]) ++at;
        ASSERT_LT(at, points.size()) << "not a point, or not in order";
        EXPECT_EQ(points.colors[at], particles.colors[i]);
        ++at;
      }
    }
  EXPECT_EQ(choose_particles(points, {.particles = {.ratio = 0.25}}).size(), 250u);
  EXPECT_EQ(choose_particles(points, {.particles = {.ratio = 1e-6}}).size(), 1u);
  EXPECT_EQ(choose_particles(points, {}).positions, points.positions);
}

TEST(Particles, UniformSubsetsDoNotFollowTheDensity) {
  // Nine tenths of the points in one half of a square.
  Random random(5);
  PointCloud points;
  for (int i = 0; i < 10000; ++i) {
    const double x = i < 9000 ? random.uniform(0, 1) : random.uniform(1, 2);
    points.positions.emplace_back(x, random.uniform(0, 1), 0);
  }
  const auto in_sparse_half = [](const PointCloud& particles) {
    return static_cast<double>(std::count_if(particles.positions.begin(), particles.positions.end(),
                                             [](const Vec3& p) { return p.x() > 1; })) /
           static_cast<double>(particles.size());
  };
  EXPECT_NEAR(in_sparse_half(choose_particles(points, {.particles = {.count = 400}})), 0.1, 0.05);
  EXPECT_NEAR(
      in_sparse_half(choose_particles(points, {.particles = {.count = 400}, .selection = ParticleSelection::uniform})),
      0.5, 0.05);
}

TEST(Particles, MoreThanPointsLieAmongThemWithoutClumps) {
  const test::SampledShape sphere = test::fibonacci_sphere(500);
  const PointCloud particles = choose_particles(sphere.cloud(), {.particles = {.ratio = 5}});
  ASSERT_EQ(particles.size(), 2500u);
  EXPECT_EQ(places(particles).size(), 2500u) << "particles coincide";
  EXPECT_GT(smallest_distance(particles), 0);
  const std::set<std::array<double, 3>> all = places(particles);
  for (const Vec3& p : sphere.points) EXPECT_TRUE(all.contains({p.x(), p.y(), p.z()}));
  // Chords to the eight nearest neighbours: not farther from the sphere than their sagitta.
  for (const Vec3& p : particles.positions) EXPECT_LT(sphere.distance(p), sphere.spacing() * sphere.spacing());
  // Every point has its share of the new ones.
  const Neighbors index(sphere.points);
  std::vector<int> share(sphere.points.size());
  std::vector<Neighbor> near;
  for (const Vec3& p : particles.positions) {
    index.nearest(p, 1, near);
    ++share[near[0].index];
  }
  EXPECT_GE(*std::min_element(share.begin(), share.end()), 1);
  EXPECT_LE(*std::max_element(share.begin(), share.end()), 13);
}

TEST(Particles, DegenerateClouds) {
  PointCloud one;
  one.positions = {{1, 2, 3}};
  EXPECT_EQ(choose_particles(one, {.particles = {.count = 4}}).positions, std::vector<Vec3>(4, Vec3(1, 2, 3)));
  PointCloud same;
  same.positions.assign(10, Vec3(1, 2, 3));
  EXPECT_EQ(choose_particles(same, {.particles = {.count = 4}, .selection = ParticleSelection::uniform}).size(), 4u);
  EXPECT_TRUE(choose_particles(PointCloud(), {.particles = {.count = 4}}).empty());
  EXPECT_THROW(choose_particles(one, {.particles = {.ratio = 0}}), OptionError);
  EXPECT_THROW(choose_particles(one, {.particles = {.ratio = 101}}), OptionError);
}

TEST(Particles, AttributesComeFromTheNearestPoint) {
  PointCloud points = test::random_sphere(300, 3).cloud();
  ScalarColumn column{"number", {}, ScalarKind::quantity};
  for (std::size_t i = 0; i < points.size(); ++i) column.values.push_back(static_cast<double>(i));
  points.scalars.push_back(column);
  PointCloud particles;
  Random random(7);
  for (int k = 0; k < 50; ++k) particles.positions.push_back(random.vector(-1, 1));
  attributes_from_nearest(particles, points);
  for (std::size_t k = 0; k < particles.size(); ++k) {
    std::size_t best = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      if ((points.positions[i] - particles.positions[k]).norm() <
          (points.positions[best] - particles.positions[k]).norm())
        best = i;
    EXPECT_EQ(particles.scalars[0].values[k], static_cast<double>(best));
  }
}

}  // namespace
}  // namespace gpsrecon
