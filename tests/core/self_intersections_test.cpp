#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/self_intersections.h>
#include <cmath>
#include <limits>

#include "support/meshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::mesh_of;

std::size_t count(const Mesh& mesh) {
  return self_intersecting_faces(mesh.positions, mesh.faces).size();
}

TEST(SelfIntersections, NoneOnASphere) {
  EXPECT_EQ(count(test::sphere(3)), 0U);
  EXPECT_EQ(count(Mesh{}), 0U);
}

TEST(SelfIntersections, TwoOctahedraCountTheFacesThatCross) {
  // The second one is shifted along x by s: its tip (s - 1, 0, 0) is inside the first.
  const Mesh one = test::octahedron();
  for (const double s : {1.9, 2.0, 2.1}) {
    Mesh two = one;
    for (const Vec3& p : one.positions) two.positions.push_back(p + Vec3(s, 0, 0));
    for (std::size_t f = 0; f < one.faces.size(); ++f)
      two.faces.add(one.faces[f][0] + 6, one.faces[f][1] + 6, one.faces[f][2] + 6);
    // Four faces around each tip cross, or touch in the common tip, or lie apart.
    EXPECT_EQ(count(two), s > 2 ? 0U : 8U) << s;
  }
}

TEST(SelfIntersections, WhatFacesShareDoesNotCount) {
  const std::vector<Vec3> p{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {-1, -1, 0}, {0.4, 0.4, 0}};
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {1, 3, 2}})), 0U);             // an edge
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {1, 0, 4}, {1, 0, 5}})), 0U);  // an edge of three faces
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {0, 5, 4}})), 0U);             // a corner
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {1, 0, 6}})), 2U);             // an edge, folded flat onto it
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {0, 1, 2}})), 2U);             // everything
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {0, 6, 4}})), 2U);             // a corner, but the side 0 6 lies in it
}

TEST(SelfIntersections, ACornerMayBeSharedAndTheRestCross) {
  // Both have the corner at the origin; the far side of the second passes through the first.
  const std::vector<Vec3> p{{0, 0, 0}, {2, -1, 0}, {2, 1, 0}, {1, 0, -1}, {1, 0, 1}, {3, 0, -1}, {3, 0, 1}};
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {0, 3, 4}})), 2U);
  // Or the far side of the first through the second.
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {0, 5, 6}})), 2U);
}

TEST(SelfIntersections, FacesNotTrianglesAreCounted) {
  // A square of two triangles pierced by one triangle in its middle.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.7, 0.2, -1}, {0.7, 0.2, 1}, {0.6, 0.3, 1}};
  mesh.faces.add(std::vector<Index>{0, 1, 2, 3});
  mesh.faces.add(4, 5, 6);
  EXPECT_EQ(count(mesh), 2U);
}

/// A segment crosses a triangle, by signs of volumes; general position.
bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto volume = [](const Vec3& w, const Vec3& x, const Vec3& y, const Vec3& z) {
    return (x - w).cross(y - w).dot(z - w);
  };
  if (volume(a, b, c, p) * volume(a, b, c, q) > 0) return false;
  const double s = volume(p, q, a, b), t = volume(p, q, b, c), u = volume(p, q, c, a);
  return (s > 0 && t > 0 && u > 0) || (s < 0 && t < 0 && u < 0);
}

TEST(SelfIntersections, EqualsBruteForceOnRandomTriangles) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Random random(seed);
    Mesh mesh;
    for (Index t = 0; t < 60; ++t) {
      const Vec3 center = random.vector();
      for (int k = 0; k < 3; ++k) mesh.positions.push_back(center + random.vector(-0.4, 0.4));
      mesh.faces.add(3 * t, 3 * t + 1, 3 * t + 2);
    }
    const auto edge_crosses = [&](std::size_t s, std::size_t t) {
      const auto at = [&](std::size_t f, std::size_t k) { return mesh.positions[3 * f + k % 3]; };
      for (std::size_t k = 0; k < 3; ++k)
        if (crosses(at(s, k), at(s, k + 1), at(t, 0), at(t, 1), at(t, 2))) return true;
      return false;
    };
    std::size_t expected = 0;
    for (std::size_t s = 0; s < 60; ++s) {
      bool hit = false;
      for (std::size_t t = 0; t < 60; ++t) hit = hit || (s != t && (edge_crosses(s, t) || edge_crosses(t, s)));
      expected += hit ? 1 : 0;
    }
    EXPECT_GT(expected, 0U);
    EXPECT_EQ(count(mesh), expected) << seed;
  }
}

TEST(SelfIntersections, TrianglesWithoutAreaDoNotCount) {
  const std::vector<Vec3> p{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.2, 0.2, 2}};
  EXPECT_EQ(count(mesh_of(p, {{0, 1, 2}, {3, 4, 5}})), 0U);
}

TEST(SelfIntersections, CornersMustBeValid) {
  Mesh mesh = test::octahedron();
  mesh.positions[3].y() = std::nan("");
  EXPECT_THROW(count(mesh), InvariantError);
  mesh.positions.resize(3);
  EXPECT_THROW(count(mesh), InvariantError);
}

}  // namespace
}  // namespace gpsrecon
