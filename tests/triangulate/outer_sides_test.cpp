#include <gtest/gtest.h>

#include <gpsrecon/triangulate/front.h>
#include <gpsrecon/triangulate/outer_sides.h>
#include <gpsrecon/triangulate/sheet_forest.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

std::vector<Vec3> outer_of(const Mixture& mixture) {
  return outer_normals(mixture, overlap_graph(mixture, 0.01, {}), sheet_normals(mixture, {}), {});
}

/// Share of the components whose outer normal is within 60° of the true one.
double right(const std::vector<Vec3>& outer, const std::vector<Vec3>& normals) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) count += outer[i].dot(normals[i]) > 0.5 ? 1 : 0;
  return static_cast<double>(count) / static_cast<double>(normals.size());
}

TEST(SheetLinks, ParallelPairsStrongestFirst) {
  const test::SampledShape sphere = test::fibonacci_sphere(200);
  const Mixture mixture = test::tangent_discs(sphere);
  const OverlapGraph graph = overlap_graph(mixture, 0.01, {});
  std::vector<Vec3> normals = sphere.normals;
  for (std::size_t i = 0; i < normals.size(); i += 2) normals[i] = -normals[i];
  normals[7].setZero();
  // Upright: at more than 45° to all it overlaps.
  normals[11] = normals[11].unitOrthogonal();
  const std::vector<SheetLink> links = sheet_links(graph, normals);
  ASSERT_GT(links.size(), 400U);
  for (std::size_t k = 0; k < links.size(); ++k) {
    const SheetLink& link = links[k];
    EXPECT_LT(link.a, link.b);
    for (const Index none : {7, 11}) EXPECT_TRUE(link.a != none && link.b != none);
    EXPECT_GT(std::abs(sphere.normals[link.a].dot(sphere.normals[link.b])), 0.7);
    EXPECT_EQ(link.sign, link.a % 2 == link.b % 2 ? 1 : -1);
    if (k > 0) {
      EXPECT_GE(links[k - 1].log_strength, link.log_strength);
    }
  }
}

TEST(OuterNormals, OfClosedShapes) {
  for (const test::SampledShape& shape : {test::fibonacci_sphere(900), test::torus(1597, 1, 0.4)})
    EXPECT_EQ(right(outer_of(test::tangent_discs(shape)), shape.normals), 1);
  // On the edges of a box the discs of a face stick out; its corners are no sheets.
  const test::SampledShape box = test::box(6000, Vec3(1, 0.7, 0.5), 4);
  EXPECT_GT(right(outer_of(test::tangent_discs(box)), box.normals), 0.995);
}

/// From inside, where no light tells, and with half of the components seen by nobody or under a right angle.
TEST(OuterNormals, FaceWhereTheyWereSeenFrom) {
  const test::SampledShape sphere = test::fibonacci_sphere(900);
  const Mixture mixture = test::tangent_discs(sphere);
  const OverlapGraph graph = overlap_graph(mixture, 0.01, {});
  std::vector<Vec3> outward, inside, sheets = sheet_normals(mixture, {});
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    inside.push_back(-sphere.normals[i]);
    const Vec3 to_the_left = Vec3(-0.5, 0, 0) - sphere.points[i];
    outward.push_back(i % 4 == 0   ? Vec3(Vec3::Zero())
                      : i % 4 == 1 ? Vec3(0.9 * sphere.normals[i].unitOrthogonal())
                                   : to_the_left.normalized());
  }
  sheets[17].setZero();  // a crease has no side
  const std::vector<Vec3> outer = outer_normals(outward, graph, sheets);
  EXPECT_TRUE(outer[17].isZero(0));
  for (std::size_t i = 0; i < outer.size(); ++i) {
    if (i == 17) continue;
    EXPECT_GT(outer[i].dot(inside[i]), 0.99) << i;
  }
  for (const Vec3& none : outer_normals(std::vector<Vec3>(mixture.size(), Vec3::Zero()), graph, sheets))
    EXPECT_TRUE(none.isZero(0));
}

TEST(OuterNormals, OfComponentsThatLieInNoSheet) {
  const test::SampledShape sphere = test::fibonacci_sphere(900);
  Mixture mixture = test::tangent_discs(sphere);
  for (Index i = 0; i < mixture.size(); i += 5) {
    mixture.covariances[i] = Sym3::identity(0.09 * mixture.spacing * mixture.spacing);
    ASSERT_EQ(sheet_normals(mixture, {})[i], Vec3::Zero());
  }
  EXPECT_EQ(right(outer_of(mixture), sphere.normals), 1);
}

TEST(OuterNormals, OfAThinPlate) {
  // Two sheets a spacing and a half apart, so thick that they overlap.
  const double thickness = 0.06;
  test::SampledShape plate = test::box(2500, Vec3(1, 0.8, thickness / 2), 9);
  const Mixture mixture = test::tangent_discs(plate, 0.8, 0.35);
  const OverlapGraph graph = overlap_graph(mixture, 0.01, {});
  std::size_t across = 0;
  for (Index i = 0; i < mixture.size(); ++i)
    for (const OverlapGraph::Link& link : graph[i]) across += plate.normals[i].dot(plate.normals[link.to]) < -0.9;
  EXPECT_GT(right(outer_of(mixture), plate.normals), 0.98);
  const OverlapGraph parted = without_opposed(graph, outer_of(mixture));
  std::size_t left = 0;
  for (Index i = 0; i < mixture.size(); ++i)
    for (const OverlapGraph::Link& link : parted[i]) left += plate.normals[i].dot(plate.normals[link.to]) < -0.9;
  ASSERT_GT(across, 500U);
  EXPECT_LT(left, across / 50);
}

TEST(OuterNormals, NoneOfOpenSheets) {
  const test::SampledShape flat = test::rectangle(800, 2, 2, 3);
  test::SampledShape waves = flat;
  for (Vec3& p : waves.points) {
    p.z() = 0.2 * std::sin(4 * p.x());
  }
  for (std::size_t i = 0; i < waves.points.size(); ++i)
    waves.normals[i] = Vec3(-0.8 * std::cos(4 * waves.points[i].x()), 0, 1).normalized();
  test::SampledShape bowl = test::fibonacci_sphere(0);
  bowl.area = 2 * std::numbers::pi;
  const test::SampledShape sphere = test::fibonacci_sphere(1600);
  for (std::size_t i = 0; i < sphere.points.size(); ++i)
    if (sphere.points[i].z() < -0.3) bowl.points.push_back(sphere.points[i]), bowl.normals.push_back(sphere.normals[i]);
  for (const test::SampledShape& shape : {flat, waves, bowl})
    for (const Vec3& n : outer_of(test::tangent_discs(shape))) EXPECT_EQ(n, Vec3::Zero());
}

TEST(OuterNormals, OfClosedPartsBesideOpenOnes) {
  const test::SampledShape sphere = test::fibonacci_sphere(900), sheet = test::rectangle(400, 1, 1, 3, 3);
  const std::vector<Vec3> outer = outer_of(test::joined(test::tangent_discs(sphere), test::tangent_discs(sheet)));
  const auto parting = outer.begin() + 900;
  EXPECT_EQ(right({outer.begin(), parting}, sphere.normals), 1);
  for (auto n = parting; n != outer.end(); ++n) EXPECT_EQ(*n, Vec3::Zero());
}

/// A round flask, whose neck opens to a flat lip: the body shades the outer side of the lip, which faces down.
test::SampledShape flask(std::size_t n, std::uint64_t seed) {
  test::Random random(seed, test::sampling);
  test::SampledShape s;
  const double start = 25 * std::numbers::pi / 180, neck = 0.5, lip = 0.85;
  const Vec3 center(1.5 * std::sin(start), 0, 1.5 * std::cos(start));  // of the arc of the neck's profile
  while (s.points.size() < n) {
    Vec3 p, normal;
    if (const double part = random.uniform(0, 3); part < 1) {
      const double angle = random.uniform(start, std::numbers::pi);
      normal = Vec3(std::sin(angle), 0, std::cos(angle));
      p = normal;
    } else if (part < 2) {
      const double angle = random.uniform(start, std::numbers::pi);
      normal = Vec3(std::sin(angle), 0, std::cos(angle));
      p = center - neck * normal;
    } else {
      normal = -Vec3::UnitZ();
      p = Vec3(random.uniform(center.x(), lip), 0, center.z() + neck);
    }
    // Evenly over the area: a strip of the profile of each part is as long as its share of arc.
    const double length = p.z() > center.z() + neck - 1e-12 ? lip - center.x() : p.norm() < 1 + 1e-9 ? 2.7 : 1.35;
    if (random.uniform() * 2.7 > p.x() * length) continue;
    const Eigen::AngleAxisd turn(random.uniform(0, 2 * std::numbers::pi), Vec3::UnitZ());
    s.points.push_back(turn * p);
    s.normals.push_back(turn * normal);
  }
  s.area = 15;
  return s;
}

TEST(OuterNormals, OfAnOpenLipGoOnFromTheBody) {
  const test::SampledShape shape = flask(2500, 6);
  Mixture mixture = test::tangent_discs(shape, 0.9, 0.1);
  std::vector<Index> rim;
  for (Index i = 0; i < mixture.size(); ++i)
    if (shape.points[i].z() > 1.8 && shape.points[i].head<2>().norm() > 0.82) {
      rim.push_back(i);
      mixture.covariances[i] = Sym3::identity(0.09 * mixture.spacing * mixture.spacing);
    }
  ASSERT_GT(rim.size(), 10U);
  const std::vector<Vec3> outer = outer_of(mixture);
  std::size_t wrong = 0, lip = 0;
  for (Index i = 0; i < mixture.size(); ++i) {
    wrong += outer[i].dot(shape.normals[i]) < 0 ? 1 : 0;
    lip += outer[i].dot(shape.normals[i]) > 0.9 && shape.points[i].z() > 1.8 ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(lip, 100U);
  // Light comes to the rim from all around and tells nothing.
  for (const Index i : rim) EXPECT_EQ(outer[i], Vec3::Zero()) << i;
}

TEST(OuterNormals, OfNestedShellsPointAwayFromTheMiddle) {
  // Light comes through the outer one; which side is material is for the orientation by containment to say.
  const test::SampledShape outer = test::fibonacci_sphere(1600), inner = test::fibonacci_sphere(500, 0.5);
  std::vector<Vec3> normals = outer.normals;
  normals.insert(normals.end(), inner.normals.begin(), inner.normals.end());
  EXPECT_EQ(right(outer_of(test::joined(test::tangent_discs(outer), test::tangent_discs(inner))), normals), 1);
}

/// A fin whose faces are closer than the Gaussians are wide, on a ball.
TEST(OuterNormals, OfAThinFinAreThoseOfItsSides) {
  test::SampledShape shape = test::fibonacci_sphere(0);
  shape.area = 4 * std::numbers::pi;
  test::Random random(12, test::sampling);
  const double half = 0.035;
  const auto fin = [&](const Vec3& p) {  // distance to |x| <= half, |y| <= 0.5, 0 <= z <= 1.8, rounded
    const Vec3 beyond(std::abs(p.x()) - 0.01, std::abs(p.y()) - 0.5, std::abs(p.z()) - 1.8);
    return beyond.cwiseMax(0).norm() + std::min(beyond.maxCoeff(), 0.0) - (half - 0.01);
  };
  const auto distance = [&](const Vec3& p) { return std::min(p.norm() - 1, fin(p)); };
  while (shape.points.size() < 6000) {
    Vec3 p = random.vector(-1.9, 1.9);
    if (std::abs(distance(p)) > 0.05) continue;
    Vec3 normal;
    for (int step = 0; step < 3; ++step) {
      for (int k = 0; k < 3; ++k)
        normal[k] = (distance(p + 1e-6 * Vec3::Unit(k)) - distance(p - 1e-6 * Vec3::Unit(k))) / 2e-6;
      p -= distance(p) * normal;
    }
    if (std::abs(distance(p)) > 1e-3) continue;
    shape.points.push_back(p);
    shape.normals.push_back(normal.normalized());
  }
  shape.area = 4 * std::numbers::pi + 4 * 1.6;
  const Mixture mixture = test::tangent_discs(shape, 0.9, 0.15);
  EXPECT_GT(right(outer_of(mixture), shape.normals), 0.97);
}

}  // namespace
}  // namespace gpsrecon
