#include <gpsrecon/core/mesh_topology.h>
#include <gtest/gtest.h>

#include <gpsrecon/triangulate/front.h>
#include <gpsrecon/triangulate/pinholes.h>
#include <gpsrecon/triangulate/triangulate.h>

#include "support/meshes.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::canonical;
using test::Random;

/// A closed triangulation of Gaussians on a sphere, all of them used, to make holes in.
class Pinholes : public testing::Test {
 protected:
  Pinholes() : mixture_(test::tangent_discs(test::fibonacci_sphere(500))), sheets_(sheet_normals(mixture_, {})) {
    full_ = triangulate(mixture_).mesh.faces;
    graph_ = overlap_graph(mixture_, options_.min_overlap, {});
  }
  void SetUp() override { ASSERT_EQ(full_.size(), 2 * mixture_.size() - 4); }

  GrowingSurface surface_without(const std::vector<std::size_t>& faces) const {
    GrowingSurface surface(mixture_.means);
    for (std::size_t f = 0; f < full_.size(); ++f)
      if (std::find(faces.begin(), faces.end(), f) == faces.end()) surface.add({full_[f][0], full_[f][1], full_[f][2]});
    return surface;
  }
  std::vector<std::size_t> star(Index v) const {
    std::vector<std::size_t> faces;
    for (std::size_t f = 0; f < full_.size(); ++f)
      if (std::find(full_[f].begin(), full_[f].end(), v) != full_[f].end()) faces.push_back(f);
    return faces;
  }
  std::size_t close(GrowingSurface& surface) const {
    return close_pinholes(surface, mixture_, graph_, sheets_, options_);
  }

  TriangulateOptions options_;
  Mixture mixture_;
  FaceList full_;
  OverlapGraph graph_;
  Sheets sheets_;
};

TEST_F(Pinholes, NothingToCloseOnAClosedSurface) {
  GrowingSurface surface = surface_without({});
  EXPECT_EQ(close(surface), 0U);
  EXPECT_EQ(canonical(surface.faces()), canonical(full_));
}

TEST_F(Pinholes, AMissingTriangleComesBack) {
  for (const std::size_t f : {0, 123, 500, 995}) {
    GrowingSurface surface = surface_without({f});
    EXPECT_EQ(close(surface), 1U);
    EXPECT_EQ(canonical(surface.faces()), canonical(full_));
  }
}

TEST_F(Pinholes, TwoTrianglesAreClosedOneWayOrTheOther) {
  const Connectivity he = build_connectivity(full_, mixture_.size());
  for (const Index h : {Index{0}, Index{301}, Index{1500}}) {
    GrowingSurface surface = surface_without({he.face(h), he.face(he.opposite[h])});
    EXPECT_EQ(close(surface), 1U);
    const Topology t = topology(surface.faces(), mixture_.size());
    EXPECT_EQ(t.boundary_loops, 0U);
    EXPECT_TRUE(t.manifold());
    EXPECT_EQ(t.euler, 2);
  }
}

TEST_F(Pinholes, AMissingStarIsClosedAroundItsVertex) {
  for (const Index v : {0U, 77U, 250U, 499U}) {
    GrowingSurface surface = surface_without(star(v));
    ASSERT_FALSE(surface.used(v));
    EXPECT_EQ(close(surface), 1U);
    EXPECT_EQ(canonical(surface.faces()), canonical(full_));
  }
}

TEST_F(Pinholes, SeveralHolesAreCounted) {
  std::vector<std::size_t> faces = star(30);
  const std::vector<std::size_t> other = star(400);
  faces.insert(faces.end(), other.begin(), other.end());
  GrowingSurface surface = surface_without(faces);
  EXPECT_EQ(close(surface), 2U);
  EXPECT_EQ(canonical(surface.faces()), canonical(full_));
}

TEST_F(Pinholes, LongerLoopsThanWantedStay) {
  const std::vector<std::size_t> hole = star(77);
  options_.max_pinhole_edges = static_cast<int>(hole.size()) - 1;
  GrowingSurface surface = surface_without(hole);
  EXPECT_EQ(close(surface), 0U);
  EXPECT_EQ(surface.faces().size(), full_.size() - hole.size());
  options_.max_pinhole_edges = static_cast<int>(hole.size());
  EXPECT_EQ(close(surface), 1U);
}

TEST_F(Pinholes, ALonePatchIsNotClosedOverItself) {
  // The boundary of a patch of two triangles, or of a star, is short, too, but runs around the patch.
  const Connectivity he = build_connectivity(full_, mixture_.size());
  for (const bool whole_star : {false, true}) {
    const std::vector<std::size_t> keep =
        whole_star ? star(77) : std::vector<std::size_t>{he.face(300), he.face(he.opposite[300])};
    GrowingSurface surface(mixture_.means);
    for (const std::size_t f : keep) surface.add({full_[f][0], full_[f][1], full_[f][2]});
    EXPECT_EQ(close(surface), 0U);
    EXPECT_EQ(surface.faces().size(), keep.size());
  }
}

}  // namespace
}  // namespace gpsrecon
