#include <gpsrecon/core/mesh_topology.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/numbers.h>
#include <gpsrecon/triangulate/flips.h>

#include "support/meshes.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;

double angle_at(const GrowingSurface& surface, Index a, Index b) {
  const Index left = surface.triangle_at(a, b), right = surface.triangle_at(b, a);
  if (left == no_index || right == no_index) return std::numbers::pi;
  return std::numbers::pi - std::acos(std::clamp(surface.normal(left).dot(surface.normal(right)), -1.0, 1.0));
}

/// Σ ln BC + ln(β/π) over the edges.
double total_grade(const GrowingSurface& surface, const OverlapGraph& graph) {
  double sum = 0;
  for (Index t = 0; t < surface.triangle_slots(); ++t) {
    if (!surface.alive(t)) continue;
    const auto corners = surface.triangle(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = corners[k], b = corners[(k + 1) % 3];
      if (a > b && surface.has(b, a)) continue;
      sum += *graph.find(a, b) + std::log(angle_at(surface, a, b) / std::numbers::pi);
    }
  }
  return sum;
}

/// Whether the edge can be flipped in a convex way, and does it.
bool try_flip(GrowingSurface& surface, const OverlapGraph& graph, Index a, Index b) {
  const Index left = surface.triangle_at(a, b), right = surface.triangle_at(b, a);
  if (left == no_index || right == no_index) return false;
  const Index c = surface.third_corner(left, a, b), d = surface.third_corner(right, a, b);
  if (surface.has(c, d) || surface.has(d, c) || graph.find(c, d) == nullptr) return false;
  if (surface.triangles_around(a).size() < 4 || surface.triangles_around(b).size() < 4) return false;
  const Vec3 n = surface.unit_normal(a, d, c), m = surface.unit_normal(d, b, c);
  for (const Vec3& before : {surface.normal(left), surface.normal(right)})
    if (n.dot(before) <= 0 || m.dot(before) <= 0) return false;
  surface.remove(std::max(left, right));
  surface.remove(std::min(left, right));
  surface.add({a, d, c});
  surface.add({d, b, c});
  return true;
}

class Flips : public testing::Test {
 protected:
  Flips() : mixture_(test::tangent_discs(test::fibonacci_sphere(300), 0.9, 0.2)) {
    graph_ = overlap_graph(mixture_, options_.min_overlap, {});
  }

  /// A closed triangulation of the sphere, spoilt by random flips.
  GrowingSurface spoilt(std::uint64_t seed) const {
    GrowingSurface surface(mixture_.means);
    const FaceList faces = triangulate(mixture_).mesh.faces;
    for (std::size_t f = 0; f < faces.size(); ++f) surface.add({faces[f][0], faces[f][1], faces[f][2]});
    Random random(seed);
    for (int i = 0; i < 200; ++i) {
      const auto t = static_cast<Index>(random.below(surface.triangle_slots()));
      if (!surface.alive(t)) continue;
      const auto corners = surface.triangle(t);
      try_flip(surface, graph_, corners[0], corners[1]);
    }
    return surface;
  }

  TriangulateOptions options_;
  Mixture mixture_;
  OverlapGraph graph_;
};

TEST_F(Flips, EndWhereNoFlipRaisesTheGrade) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    GrowingSurface surface = spoilt(seed);
    const double before = total_grade(surface, graph_);
    const std::size_t flips = flip_edges(surface, graph_, options_);
    EXPECT_GT(flips, 0U);
    const double after = total_grade(surface, graph_);
    EXPECT_GT(after, before);
    const Topology t = topology(surface.faces(), mixture_.size());
    EXPECT_TRUE(t.manifold());
    EXPECT_EQ(t.euler, 2);
    EXPECT_EQ(t.boundary_loops, 0U);
    // No single flip is left, whatever its edge.
    const FaceList faces = surface.faces();
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k) {
        GrowingSurface trial = surface;
        if (!try_flip(trial, graph_, faces[f][k], faces[f][(k + 1) % 3])) continue;
        double smallest = std::numbers::pi;
        const FaceList flipped = trial.faces();
        for (std::size_t g = 0; g < flipped.size(); ++g)
          for (std::size_t j = 0; j < 3; ++j)
            smallest = std::min(smallest, angle_at(trial, flipped[g][j], flipped[g][(j + 1) % 3]));
        if (smallest > radians(options_.min_dihedral)) {
          EXPECT_LE(total_grade(trial, graph_), after + 1e-8);
        }
      }
    EXPECT_EQ(flip_edges(surface, graph_, options_), 0U);
  }
}

TEST_F(Flips, ReachTheSameSurfaceFromEqualOnes) {
  GrowingSurface one = spoilt(9), two = spoilt(9);
  flip_edges(one, graph_, options_);
  flip_edges(two, graph_, options_);
  EXPECT_EQ(one.faces(), two.faces());
}

TEST(FlipsOfAQuad, TakeTheShorterDiagonalOnlyWhereItStaysInside) {
  // Round Gaussians: the shorter diagonal overlaps more. In the concave quad it lies outside.
  for (const bool concave : {false, true}) {
    Mixture m;
    m.means = {Vec3(-2, 0, 0), Vec3(2, 0, 0), concave ? Vec3(1.5, 0.5, 0) : Vec3(0, 1, 0),
               concave ? Vec3(3, -0.5, 0) : Vec3(0, -1, 0)};
    // Around them, so that no vertex loses its third edge.
    for (const Vec3& p : {Vec3(0, 4, 0), Vec3(0, -4, 0), Vec3(-4, 0, 0), Vec3(5, 0, 0)}) m.means.push_back(p);
    m.covariances.assign(m.means.size(), Sym3::identity(1));
    m.weights.assign(m.means.size(), 1.0);
    const OverlapGraph graph = overlap_graph(m, 1e-9, {});
    GrowingSurface surface(m.means);
    surface.add({0, 1, 2});
    surface.add({1, 0, 3});
    surface.add({0, 2, 6});
    surface.add({0, 6, 5});
    surface.add({0, 5, 3});
    surface.add({1, 3, 7});
    surface.add({1, 7, 4});
    surface.add({1, 4, 2});
    flip_edges(surface, graph, {});
    EXPECT_EQ(surface.has(0, 1), concave);
    if (!concave) {
      EXPECT_TRUE(surface.has(2, 3) && surface.has(3, 2));
    }
  }
}

}  // namespace
}  // namespace gpsrecon
