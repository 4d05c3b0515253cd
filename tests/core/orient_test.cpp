#include <gtest/gtest.h>

#include <gpsrecon/core/orient.h>
#include <bit>

#include "support/meshes.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

// With the connectivity of the faces, which is to stay that.
std::size_t orient(const Mixture& vertices, FaceList& faces, const std::optional<Vec3>& sensor) {
  Connectivity connectivity = build_connectivity(faces, vertices.size());
  const std::size_t turned = internal::orient(vertices, faces, connectivity, sensor);
  EXPECT_EQ(connectivity.corners, faces.corners);
  return turned;
}

std::size_t orient_by_vote(const Mixture& vertices, FaceList& faces, const PointCloud& cloud,
                           std::span<const Vec3> directions) {
  Connectivity connectivity = build_connectivity(faces, vertices.size());
  const std::size_t turned = internal::orient_by_vote(vertices, faces, connectivity, cloud, directions);
  EXPECT_EQ(connectivity.corners, faces.corners);
  return turned;
}

using test::Random;

TEST(Orient, TurnsOutwardAndTowardsTheSensor) {
  // An octahedron, inside out, and a triangle of the plane z = 0 that faces down.
  Mixture m;
  m.means = {Vec3(1, 0, 0),  Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1),
             Vec3(0, 0, -1), Vec3(5, 0, 0),  Vec3(6, 0, 0), Vec3(5, 1, 0)};
  m.covariances.assign(9, Sym3::identity(0.1));
  m.weights.assign(9, 1.0);
  FaceList faces;
  for (const Index z : {4U, 5U}) {
    const std::array<Index, 4> ring = z == 4 ? std::array<Index, 4>{0, 2, 1, 3} : std::array<Index, 4>{0, 3, 1, 2};
    for (std::size_t k = 0; k < 4; ++k) faces.add(z, ring[(k + 1) % 4], ring[k]);
  }
  faces.add(6, 8, 7);
  const auto z_of_last = [&](const FaceList& f) { return test::area_vector(f, 8, m.means).z(); };
  for (const double height : {3.0, -3.0}) {
    FaceList turned = faces;
    EXPECT_EQ(orient(m, turned, Vec3(5, 0, height)), height > 0 ? 2U : 1U);
    EXPECT_GT(z_of_last(turned) * height, 0);
    turned = FaceList();
    for (std::size_t f = 0; f < 8; ++f) turned.add(faces[f]);
    orient(m, turned, Vec3(5, 0, height));
    EXPECT_NEAR(test::volume(turned, m.means), 4.0 / 3, 1e-14);
    EXPECT_EQ(orient(m, turned, std::nullopt), 0U);
  }
}

TEST(Orient, TurnsClosedComponentsToWhereTheyWereSeenFrom) {
  for (const double side : {1.0, -1.0}) {
    const Mesh mesh = test::sphere(1);
    Mixture m;
    m.means = mesh.positions;
    m.covariances.assign(m.size(), Sym3::identity(0.1));
    m.weights.assign(m.size(), 1.0);
    for (const Vec3& p : m.means) m.outward.push_back(side * 0.7 * p);
    m.outward.front().setZero();  // a vertex that nobody saw
    FaceList faces = mesh.faces;
    Connectivity connectivity = build_connectivity(faces, m.size());
    EXPECT_EQ(orient_outward(m, faces, connectivity), side > 0 ? 0U : 1U);
    EXPECT_GT(side * test::volume(faces, m.means), 0);
    EXPECT_EQ(connectivity.corners, faces.corners);
    EXPECT_EQ(orient_outward(m, faces, connectivity), 0U);
  }
}

TEST(Orient, RoundingDoesNotChooseTheSideOfAFlatSheet) {
  // The flux from the centroid of a flat sheet is nothing but rounding, of another sign in other units.
  Random random(42);
  for (int trial = 0; trial < 20; ++trial) {
    const Mat3 turn = Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()).toRotationMatrix();
    Mixture m;
    FaceList faces;
    for (Index i = 0; i < 30; ++i) {
      const Index column = i % 6, row = i / 6;
      const Vec3 p = turn * Vec3(column + random.uniform(0, 0.5), row + random.uniform(0, 0.5), 0);
      m.means.push_back(p);
      if (column == 5 || row == 4) continue;
      faces.add(i, i + 1, i + 7);
      faces.add(i, i + 7, i + 6);
    }
    m.covariances.assign(m.size(), Sym3::identity(0.1));
    m.weights.assign(m.size(), 1.0);
    const bool up = turn(2, 2) > 0;
    for (const double factor : {1.0, 1000.0, 0.3, 1e-5}) {
      Mixture scaled = m;
      for (Vec3& mean : scaled.means) mean *= factor;
      FaceList turned = faces;
      EXPECT_EQ(orient(scaled, turned, std::nullopt), up ? 0U : 1U);
      EXPECT_GT(test::area_vector(turned, 0, scaled.means).z(), 0);
    }
  }
  const auto upright = [](const Vec3& u, const Vec3& v) {
    Mixture m;
    m.means = {Vec3(1, 2, 3), Vec3(1, 2, 3) + u, Vec3(1, 2, 3) + v};
    m.covariances.assign(3, Sym3::identity(0.1));
    m.weights.assign(3, 1.0);
    FaceList faces;
    faces.add(0, 1, 2);
    orient(m, faces, std::nullopt);
    return Vec3(test::area_vector(faces, 0, m.means).normalized());
  };
  EXPECT_EQ(upright(Vec3::UnitX(), Vec3::UnitZ()), Vec3::UnitY());
  EXPECT_EQ(upright(Vec3::UnitZ(), Vec3::UnitX()), Vec3::UnitY());
  EXPECT_EQ(upright(Vec3::UnitZ(), Vec3::UnitY()), Vec3::UnitX());
}

/// A closed sphere of a regular mesh, outward or turned over, appended.
void add_octahedron(Mixture& m, FaceList& faces, double radius, const Vec3& center, bool outward) {
  const auto first = static_cast<Index>(m.size());
  for (const double side : {1.0, -1.0})
    for (const int axis : {0, 1, 2}) m.means.push_back(center + side * radius * Vec3::Unit(axis));
  m.covariances.resize(m.size(), Sym3::identity(0.1));
  m.weights.resize(m.size(), 1.0);
  for (const Index x : {0U, 3U})
    for (const Index y : {1U, 4U})
      for (const Index z : {2U, 5U}) {
        const bool even = ((x > 0 ? 1 : 0) + (y > 1 ? 1 : 0) + (z > 2 ? 1 : 0)) % 2 == 0;
        if (even == outward)
          faces.add(first + x, first + y, first + z);
        else
          faces.add(first + y, first + x, first + z);
      }
}

TEST(Orient, ShellsAlternateWithTheirDepth) {
  // Four shells inside each other, and one beside the second, in all combinations of turned-over ones.
  for (unsigned turned = 0; turned < 32; ++turned) {
    Mixture m;
    FaceList faces;
    for (unsigned k = 0; k < 4; ++k)
      add_octahedron(m, faces, 16.0 / (1 << (2 * k)), Vec3(0.01, 0.02, 0.03) * k, (turned >> k & 1) == 0);
    add_octahedron(m, faces, 1, Vec3(0, 0, 8), (turned >> 4 & 1) == 0);
    const unsigned right = 0b11010;  // depths 0, 1, 2, 3, and 1
    EXPECT_EQ(orient(m, faces, std::nullopt), static_cast<std::size_t>(std::popcount(turned ^ right)));
    for (unsigned k = 0; k < 5; ++k) {
      FaceList one;
      for (std::size_t f = 8 * k; f < 8 * k + 8; ++f) one.add(faces[f]);
      EXPECT_EQ(test::volume(one, m.means) < 0, (right >> k & 1) == 1) << turned << " " << k;
    }
    EXPECT_EQ(orient(m, faces, Vec3(0, 0, 100)), 0U);
  }
}

TEST(Orient, AnOpenSheetAroundAClosedOneIsNoShell) {
  Mixture m;
  FaceList faces;
  add_octahedron(m, faces, 16, Vec3::Zero(), true);
  FaceList open;
  for (std::size_t f = 1; f < 8; ++f) open.add(faces[f]);
  add_octahedron(m, open, 1, Vec3::Zero(), true);
  EXPECT_EQ(orient(m, open, std::nullopt), 0U);
}

TEST(Orient, PointsVoteOnOpenComponentsOnly) {
  // Two sheets of two triangles and a closed octahedron, turned over. Three points at each with directions down, down
  // and up, of any length; weights let the single one win at the second sheet. What is not finite does not count.
  Mixture m;
  FaceList faces;
  PointCloud cloud;
  std::vector<Vec3> directions;
  for (const double x : {0.0, 10.0}) {
    const auto first = static_cast<Index>(m.size());
    m.means.insert(m.means.end(), {Vec3(x, 0, 0), Vec3(x + 1, 0, 0), Vec3(x + 1, 1, 0), Vec3(x, 1, 0)});
    faces.add(first, first + 1, first + 2);
    faces.add(first, first + 2, first + 3);
    cloud.positions.insert(cloud.positions.end(), 4, Vec3(x + 0.1, 0.1, 0.3));
    cloud.weights.insert(cloud.weights.end(), {1, 1, x > 0 ? 3.0 : 1.0, 100});
    directions.insert(directions.end(), {Vec3(0.5, 0, -9), Vec3(0, 0, -0.1), Vec3(0, 0, 1), Vec3(0, std::nan(""), 1)});
  }
  add_octahedron(m, faces, 1, Vec3(20, 0, 0), true);
  cloud.positions.emplace_back(20, 0, 1.1);
  cloud.weights.push_back(1000);
  directions.emplace_back(0, 0, -1);
  FaceList turned = faces;
  EXPECT_EQ(orient_by_vote(m, turned, cloud, directions), 1U);
  EXPECT_LT(test::area_vector(turned, 0, m.means).z(), 0);
  EXPECT_LT(test::area_vector(turned, 1, m.means).z(), 0);
  for (std::size_t f = 2; f < faces.size(); ++f)
    EXPECT_EQ(test::area_vector(turned, f, m.means), test::area_vector(faces, f, m.means));
  EXPECT_EQ(orient_by_vote(m, turned, cloud, directions), 0U);
}

}  // namespace
}  // namespace gpsrecon
