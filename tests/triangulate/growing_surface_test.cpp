#include <gtest/gtest.h>

#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/triangulate/growing_surface.h>

#include "support/meshes.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using Triangle = GrowingSurface::Triangle;
using Fan = GrowingSurface::Fan;
using test::Random;

/// The surface's own adjacency against the half-edges of its list of faces.
void expect_consistent(const GrowingSurface& surface, const std::vector<Vec3>& positions) {
  const std::size_t n = positions.size();
  const FaceList faces = surface.faces();
  const Connectivity he = build_connectivity(faces, n);
  ASSERT_EQ(he.nonmanifold_edges, 0U);
  ASSERT_EQ(he.inconsistent_edges, 0U);
  std::map<std::pair<Index, Index>, Index> half_edge;
  for (Index h = 0; h < faces.corners.size(); ++h) half_edge[{he.source(h), he.target(h)}] = h;
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b) {
      const auto at = half_edge.find({a, b});
      ASSERT_EQ(surface.has(a, b), at != half_edge.end());
      ASSERT_EQ(surface.on_front(a, b), at != half_edge.end() && he.opposite[at->second] == no_index);
      if (at == half_edge.end()) continue;
      const Index t = surface.triangle_at(a, b);
      ASSERT_TRUE(surface.alive(t));
      const Index c = he.source(he.previous(at->second));
      ASSERT_EQ(surface.third_corner(t, a, b), c);
      const Vec3 normal = (positions[b] - positions[a]).cross(positions[c] - positions[a]).normalized();
      ASSERT_LT((surface.normal(t) - normal).norm(), 1e-12);
    }
  const std::vector<Index> fan_count = vertex_fans(he);
  std::vector<Fan> fans;
  for (Index v = 0; v < n; ++v) {
    surface.fans(v, fans);
    ASSERT_EQ(fans.size(), fan_count[v]);
    ASSERT_EQ(surface.used(v), fan_count[v] > 0);
    std::size_t triangles = 0;
    bool open = false;
    for (const Fan& fan : fans) {
      triangles += fan.triangles;
      open = open || !fan.closed();
      // Turning counter-clockwise from the first edge ends at the last one after as many triangles.
      Index at = fan.first;
      for (std::size_t k = 0; k < fan.triangles; ++k) {
        const Index t = surface.triangle_at(v, at);
        ASSERT_NE(t, no_index);
        at = surface.third_corner(t, v, at);
      }
      ASSERT_EQ(at, fan.last);
      ASSERT_EQ(fan.closed(), surface.has(fan.first, v));
      if (!fan.closed()) {
        ASSERT_FALSE(surface.has(v, fan.last));
      }
    }
    ASSERT_EQ(triangles, surface.triangles_around(v).size());
    ASSERT_EQ(surface.can_grow(v), fans.empty() || open);
  }
}

TEST(GrowingSurface, AgreesWithHalfEdgesThroughRandomEdits) {
  Random random(41);
  std::size_t closed_fans = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const auto n = static_cast<Index>(4 + random.below(6));
    std::vector<Vec3> positions;
    for (Index i = 0; i < n; ++i) positions.push_back(random.vector(0, 1));
    GrowingSurface surface(positions);
    std::size_t count = 0;
    for (int step = 0; step < 120; ++step) {
      if (random.uniform() < 0.25 && surface.triangle_slots() > 0) {
        const auto t = static_cast<Index>(random.below(surface.triangle_slots()));
        if (surface.alive(t)) surface.remove(t), --count;
      } else {
        const Triangle t{static_cast<Index>(random.below(n)), static_cast<Index>(random.below(n)),
                         static_cast<Index>(random.below(n))};
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        if (surface.has(t[0], t[1]) || surface.has(t[1], t[2]) || surface.has(t[2], t[0])) continue;
        const Index number = surface.add(t);
        ++count;
        ASSERT_EQ(surface.triangle(number), t);
      }
      ASSERT_EQ(surface.faces().size(), count);
      expect_consistent(surface, positions);
      if (HasFatalFailure()) return;
    }
    std::vector<Fan> fans;
    for (Index v = 0; v < n; ++v) {
      surface.fans(v, fans);
      for (const Fan& fan : fans) closed_fans += fan.closed() ? 1 : 0;
    }
  }
  EXPECT_GT(closed_fans, 10U);
}

TEST(GrowingSurface, AddAndRemoveIsNothing) {
  const std::vector<Vec3> positions = test::fibonacci_sphere(6).points;
  GrowingSurface surface(positions);
  const Index first = surface.add({0, 1, 2});
  const Index second = surface.add({0, 2, 3});
  surface.remove(second);
  EXPECT_EQ(surface.triangle_slots(), 1U);
  surface.add({0, 2, 4});
  surface.remove(first);
  EXPECT_FALSE(surface.alive(first));
  EXPECT_FALSE(surface.used(1));
  EXPECT_EQ(test::canonical(surface.faces()), (std::vector<Triangle>{{0, 2, 4}}));
}

TEST(GrowingSurface, FlatTrianglesHaveNoNormal) {
  const std::vector<Vec3> line{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(0, 3, 0)};
  const GrowingSurface surface(line);
  EXPECT_EQ(surface.unit_normal(0, 1, 2), Vec3::Zero());
  EXPECT_EQ(surface.unit_normal(0, 1, 3), Vec3::UnitZ());
  EXPECT_EQ(surface.unit_normal(0, 3, 1), -Vec3::UnitZ());
}

}  // namespace
}  // namespace gpsrecon
