// Neighbour search against brute force.

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/random.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

std::vector<Neighbor> all_sorted(const std::vector<Vec3>& points, const Vec3& query) {
  std::vector<Neighbor> all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Compared by squared distance, as ties are exact there.
    const Vec3 d = points[i] - query;
    all.push_back({static_cast<Index>(i), d.x() * d.x() + d.y() * d.y() + d.z() * d.z()});
  }
  std::sort(all.begin(), all.end());
  for (Neighbor& n : all) n.distance = std::sqrt(n.distance);
  return all;
}

void expect_same(const std::vector<Neighbor>& found, const std::vector<Neighbor>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].index, expected[i].index) << "at place " << i;
    ASSERT_DOUBLE_EQ(found[i].distance, expected[i].distance);
  }
}

void compare_with_brute_force(const std::vector<Vec3>& points, const std::vector<Vec3>& queries) {
  const Neighbors index(points);
  EXPECT_EQ(index.size(), points.size());
  std::vector<Neighbor> found;
  for (const Vec3& query : queries) {
    const std::vector<Neighbor> all = all_sorted(points, query);
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}, std::size_t{7}, points.size(), points.size() + 5}) {
      index.nearest(query, k, found);
      expect_same(found, {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(k, all.size()))});
    }
    for (const double radius : {0.0, 0.1, 0.5, 1.0, 2.0, 100.0}) {
      std::vector<Neighbor> inside;
      for (const Neighbor& n : all)
        if ((points[n.index] - query).squaredNorm() <= radius * radius) inside.push_back(n);
      std::sort(inside.begin(), inside.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
      index.within(query, radius, found);
      expect_same(found, inside);
    }
  }
}

TEST(Neighbors, AgreeWithBruteForceOnRandomPoints) {
  const std::vector<Vec3> points = Random(1).vectors(1000);
  std::vector<Vec3> queries = Random(2).vectors(50);
  queries.insert(queries.end(), points.begin(), points.begin() + 20);
  queries.emplace_back(50, -3, 7);  // far outside
  compare_with_brute_force(points, queries);
}

TEST(Neighbors, BreakTiesByIndexOnLattices) {
  std::vector<Vec3> lattice;
  for (int x = 0; x < 7; ++x)
    for (int y = 0; y < 7; ++y)
      for (int z = 0; z < 7; ++z) lattice.emplace_back(0.5 * x, 0.5 * y, 0.5 * z);
  // In shuffled order, so that index and place have nothing to do with each other.
  Random random(3);
  for (std::size_t i = lattice.size(); i > 1; --i) std::swap(lattice[i - 1], lattice[random.below(i)]);
  std::vector<Vec3> queries(lattice.begin(), lattice.begin() + 40);
  queries.emplace_back(0.25, 0.25, 0.25);
  queries.emplace_back(1.5, 1.5, 1.25);
  compare_with_brute_force(lattice, queries);
}

TEST(Neighbors, HandleDuplicatesAndFlatSets) {
  std::vector<Vec3> points = Random(4).vectors(60);
  for (int copies = 0; copies < 5; ++copies) points.insert(points.end(), points.begin(), points.begin() + 30);
  compare_with_brute_force(points, Random(5).vectors(20));
  compare_with_brute_force(std::vector<Vec3>(50, Vec3(1, 2, 3)), {{1, 2, 3}, {0, 0, 0}});
  std::vector<Vec3> line;
  for (int i = 0; i < 100; ++i) line.emplace_back(0.1 * (i % 50), 0, 0);
  compare_with_brute_force(line, {{0, 0, 0}, {2.5, 0.1, 0}, {2.45, 0, 0}});
}

TEST(Neighbors, HandleTinySets) {
  compare_with_brute_force({}, {{0, 0, 0}});
  compare_with_brute_force({{1, 2, 3}}, {{1, 2, 3}, {0, 0, 0}});
  compare_with_brute_force({{1, 2, 3}, {4, 5, 6}}, {{1, 2, 3}, {2.5, 3.5, 4.5}});
}

TEST(Neighbors, FindNothingInNegativeOrUndefinedRadii) {
  const Neighbors index(Random(6).vectors(10));
  std::vector<Neighbor> found(3);
  index.within(Vec3::Zero(), -1, found);
  EXPECT_TRUE(found.empty());
  index.within(Vec3::Zero(), std::nan(""), found);
  EXPECT_TRUE(found.empty());
}

TEST(Neighbors, ManyQueriesMayRunAtOnce) {
  const std::vector<Vec3> points = Random(7).vectors(5000);
  const Neighbors index(points);
  RunContext context;
  context.threads = 4;
  std::vector<Index> second(points.size());
  parallel_blocks(
      points.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> found;
        for (std::size_t i = begin; i < end; ++i) {
          index.nearest(points[i], 2, found);
          second[i] = found[1].index;
        }
      },
      64);
  std::vector<Neighbor> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    index.nearest(points[i], 2, found);
    ASSERT_EQ(found[0].index, i);
    ASSERT_EQ(found[1].index, second[i]);
  }
}

TEST(Neighbors, KeepACopyOfThePoints) {
  std::vector<Vec3> points = Random(8).vectors(100);
  const Vec3 query = points[17];
  Neighbors index(points);
  for (Vec3& p : points) p.setConstant(1e9);
  Neighbors moved = std::move(index);
  std::vector<Neighbor> found;
  moved.nearest(query, 1, found);
  EXPECT_EQ(found.at(0).index, 17u);
  EXPECT_EQ(found.at(0).distance, 0);
}

}  // namespace
}  // namespace gpsrecon::test
