#include <gpsrecon/core/mesh_topology.h>
#include <gtest/gtest.h>

#include <gpsrecon/triangulate/growing_surface.h>
#include <gpsrecon/triangulate/pieces.h>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "support/connectivity.h"
#include "support/meshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::canonical;
using test::expect_connectivity;

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// With the connectivity of the faces, which is to stay that.
std::size_t split_vertices(Mixture& vertices, std::vector<Index>& component_of_vertex, FaceList& faces) {
  Connectivity connectivity = build_connectivity(faces, vertices.size());
  const std::size_t copies = internal::split_vertices(vertices, component_of_vertex, faces, connectivity);
  expect_connectivity(connectivity, faces, vertices.size());
  return copies;
}

DroppedComponents drop_small_components(const Mixture& vertices, const OverlapGraph& graph, FaceList& faces,
                                        double min_share) {
  Connectivity connectivity = build_connectivity(faces, vertices.size());
  const DroppedComponents dropped = internal::drop_small_components(vertices, graph, faces, connectivity, min_share);
  expect_connectivity(connectivity, faces, vertices.size());
  return dropped;
}

TEST(Pieces, SplitsABowTie) {
  //  1       4
  //  | \   / |
  //  |   2   |   two triangles that share vertex 2 only
  //  | /   \ |
  //  0       3
  Mixture m;
  m.means = {Vec3(-1, -1, 0), Vec3(-1, 1, 0), Vec3(0, 0, 0), Vec3(1, -1, 0), Vec3(1, 1, 0)};
  m.covariances.assign(5, Sym3::identity(0.1));
  m.covariances[2] = Sym3::identity(0.7);
  m.weights = {1, 2, 6, 4, 5};
  m.normals.assign(5, Vec3::UnitZ());
  m.normal_variances = {0, 0, 0.25, 0, 0};
  FaceList faces;
  faces.add(0, 2, 1);
  faces.add(2, 3, 4);
  std::vector<Index> component{10, 11, 12, 13, 14};
  EXPECT_EQ(topology(faces, 5).nonmanifold_vertices, 1U);
  EXPECT_EQ(split_vertices(m, component, faces), 1U);
  ASSERT_EQ(m.size(), 6U);
  ASSERT_NO_THROW(validate(m));
  ASSERT_NO_THROW(validate(CovMesh{m, faces}));
  EXPECT_EQ(component, (std::vector<Index>{10, 11, 12, 13, 14, 12}));
  EXPECT_EQ(m.weights, (std::vector<double>{1, 2, 3, 4, 5, 3}));
  EXPECT_EQ(m.covariances[5], m.covariances[2]);
  EXPECT_EQ(m.normal_variances[5], 0.25);
  // Each copy moves a tenth of the way to the centroid of its neighbours, (∓1, 0, 0).
  const std::array<double, 2> x{m.means[faces.corners[1]].x(), m.means[faces.corners[3]].x()};
  EXPECT_NEAR(x[0], -0.1, 1e-15);
  EXPECT_NEAR(x[1], 0.1, 1e-15);
  EXPECT_EQ(topology(faces, 6).components, 2U);
  EXPECT_EQ(topology(test::welded(faces, m.means), 6).nonmanifold_vertices, 0U);
  EXPECT_EQ(split_vertices(m, component, faces), 0U);
}

TEST(Pieces, SplitsIntoAsManyFansAsThereAre) {
  // k triangles around one vertex, none sharing an edge.
  for (const Index k : {2U, 3U, 5U}) {
    Mixture m;
    m.means = {Vec3::Zero()};
    FaceList faces;
    for (Index i = 0; i < k; ++i) {
      const double angle = 2 * std::numbers::pi * i / k;
      m.means.emplace_back(std::cos(angle), std::sin(angle), 0);
      m.means.emplace_back(std::cos(angle + 0.5), std::sin(angle + 0.5), 0);
      faces.add(0, 2 * i + 1, 2 * i + 2);
    }
    m.covariances.assign(m.means.size(), Sym3::identity(0.1));
    m.weights.assign(m.means.size(), 1.5);
    std::vector<Index> component(m.size());
    std::iota(component.begin(), component.end(), Index{0});
    const double before = sum(m.weights);
    EXPECT_EQ(split_vertices(m, component, faces), k - 1);
    EXPECT_NEAR(sum(m.weights), before, 1e-14);
    ASSERT_NO_THROW(validate(CovMesh{m, faces}));
    EXPECT_TRUE(topology(test::welded(faces, m.means), m.size()).manifold());
  }
}

/// A triangle of weight 3 w at x = offset.
void add_triangle(Mixture& m, FaceList& faces, double offset, double w) {
  const auto first = static_cast<Index>(m.size());
  m.means.insert(m.means.end(), {Vec3(offset, 0, 0), Vec3(offset + 1, 0, 0), Vec3(offset, 1, 0)});
  m.covariances.insert(m.covariances.end(), 3, Sym3::identity(0.1));
  m.weights.insert(m.weights.end(), 3, w);
  faces.add(first, first + 1, first + 2);
}

TEST(Pieces, ComponentsBelowTheShareAreDropped) {
  Mixture m;
  FaceList faces;
  add_triangle(m, faces, 0, 300);
  add_triangle(m, faces, 5, 1);
  add_triangle(m, faces, 10, 30);
  add_triangle(m, faces, 15, 2);
  const DroppedComponents dropped = drop_small_components(m, {}, faces, 0.01);  // of 999
  EXPECT_EQ(dropped.count, 2U);
  EXPECT_EQ(dropped.weight, 9.0);
  EXPECT_EQ(canonical(faces), (std::vector<GrowingSurface::Triangle>{{0, 1, 2}, {6, 7, 8}}));
  EXPECT_EQ(drop_small_components(m, {}, faces, 0.01).count, 0U);
}

TEST(Pieces, TheHeaviestComponentStays) {
  Mixture m;
  FaceList faces;
  add_triangle(m, faces, 0, 1);
  add_triangle(m, faces, 5, 1.5);
  m.means.emplace_back(100, 0, 0);  // most of the weight is in no face
  m.covariances.push_back(Sym3::identity());
  m.weights.push_back(1e6);
  EXPECT_EQ(drop_small_components(m, {}, faces, 0.5).count, 1U);
  EXPECT_EQ(canonical(faces), (std::vector<GrowingSurface::Triangle>{{3, 4, 5}}));
}

TEST(Pieces, AVertexOfASmallComponentAndOfTheRestStays) {
  // Vertex 0 is shared by a small component and what stays: its weight is not lost. Faces of the two alternate in the
  // list.
  Mixture m;
  m.means = {Vec3(0, 0, 0),  Vec3(1, 0, 0),   Vec3(1, 1, 0), Vec3(0, 1, 0),
             Vec3(-1, 0, 0), Vec3(-1, -1, 0), Vec3(0, -1, 0)};
  m.covariances.assign(7, Sym3::identity(0.1));
  m.weights = {4, 100, 100, 100, 1, 1, 1};
  FaceList faces;
  faces.add(0, 1, 2);
  faces.add(0, 4, 5);
  faces.add(0, 2, 3);
  faces.add(0, 5, 6);
  FaceList with_share = faces;
  // The small component has weight 4 + 3.
  EXPECT_EQ(drop_small_components(m, {}, with_share, 7.5 / 307).count, 1U);
  with_share = faces;
  EXPECT_EQ(drop_small_components(m, {}, with_share, 6.5 / 307).count, 0U);
  const DroppedComponents dropped = drop_small_components(m, {}, faces, 0.1);
  EXPECT_EQ(dropped.count, 1U);
  EXPECT_EQ(dropped.weight, 3.0);
  EXPECT_EQ(faces.size(), 2U);
}

}  // namespace
}  // namespace gpsrecon
