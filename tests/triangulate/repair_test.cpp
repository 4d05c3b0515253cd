#include <gtest/gtest.h>

#include <gpsrecon/triangulate/front.h>
#include <gpsrecon/triangulate/orient.h>
#include <gpsrecon/triangulate/pieces.h>
#include <gpsrecon/triangulate/pinholes.h>
#include <gpsrecon/triangulate/triangulate.h>
#include <support/shapes.h>
#include <triangulate/mesh_checks.h>

namespace gpsrecon {
namespace {

using test::canonical;
using test::Random;

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// A closed triangulation of Gaussians on a sphere, all of them used, to make holes in.
class Pinholes : public testing::Test {
 protected:
  Pinholes() : mixture_(test::tangent_discs(test::fibonacci_sphere(500))) {
    full_ = triangulate(mixture_).mesh.faces;
    graph_ = overlap_graph(mixture_, options_.min_overlap, {});
    sheets_ = sheet_normals(mixture_, {});
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
  std::vector<Vec3> sheets_;
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
  const HalfEdges he = half_edges(full_, mixture_.size());
  for (const Index h : {Index{0}, Index{301}, Index{1500}}) {
    GrowingSurface surface = surface_without({he.face[h], he.face[he.opposite[h]]});
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
  const HalfEdges he = half_edges(full_, mixture_.size());
  for (const bool whole_star : {false, true}) {
    const std::vector<std::size_t> keep =
        whole_star ? star(77) : std::vector<std::size_t>{he.face[300], he.face[he.opposite[300]]};
    GrowingSurface surface(mixture_.means);
    for (const std::size_t f : keep) surface.add({full_[f][0], full_[f][1], full_[f][2]});
    EXPECT_EQ(close(surface), 0U);
    EXPECT_EQ(surface.faces().size(), keep.size());
  }
}

TEST(Repair, SplitsABowTie) {
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

TEST(Repair, SplitsIntoAsManyFansAsThereAre) {
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

TEST(Repair, SpecksBelowTheShareAreDropped) {
  Mixture m;
  FaceList faces;
  add_triangle(m, faces, 0, 300);
  add_triangle(m, faces, 5, 1);
  add_triangle(m, faces, 10, 30);
  add_triangle(m, faces, 15, 2);
  const Specks specks = drop_specks(m, faces, 0.01);  // of 999
  EXPECT_EQ(specks.count, 2U);
  EXPECT_EQ(specks.weight, 9.0);
  EXPECT_EQ(canonical(faces), (std::vector<GrowingSurface::Triangle>{{0, 1, 2}, {6, 7, 8}}));
  EXPECT_EQ(drop_specks(m, faces, 0.01).count, 0U);
}

TEST(Repair, TheHeaviestComponentIsNoSpeck) {
  Mixture m;
  FaceList faces;
  add_triangle(m, faces, 0, 1);
  add_triangle(m, faces, 5, 1.5);
  m.means.emplace_back(100, 0, 0);  // most of the weight is in no face
  m.covariances.push_back(Sym3::identity());
  m.weights.push_back(1e6);
  EXPECT_EQ(drop_specks(m, faces, 0.5).count, 1U);
  EXPECT_EQ(canonical(faces), (std::vector<GrowingSurface::Triangle>{{3, 4, 5}}));
}

TEST(Repair, AVertexOfASpeckAndOfTheRestStays) {
  // Vertex 0 is shared by a speck and what stays: its weight is not lost. Faces of the two alternate in the list.
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
  EXPECT_EQ(drop_specks(m, with_share, 7.5 / 307).count, 1U);
  with_share = faces;
  EXPECT_EQ(drop_specks(m, with_share, 6.5 / 307).count, 0U);
  const Specks specks = drop_specks(m, faces, 0.1);
  EXPECT_EQ(specks.count, 1U);
  EXPECT_EQ(specks.weight, 3.0);
  EXPECT_EQ(faces.size(), 2U);
}

TEST(Repair, TurnsOutwardAndTowardsTheSensor) {
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
    EXPECT_NEAR(test::signed_volume(turned, m.means), 4.0 / 3, 1e-14);
    EXPECT_EQ(orient(m, turned, std::nullopt), 0U);
  }
}

TEST(Repair, RoundingDoesNotChooseTheSideOfAFlatSheet) {
  // The flux from the centroid of a flat sheet is nothing but rounding, of another sign in other units.
  Random random(42);
  for (int trial = 0; trial < 20; ++trial) {
    const Mat3 turn = Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()).toRotationMatrix();
    Mixture m;
    FaceList faces;
    for (Index i = 0; i < 30; ++i) {
      const Vec3 p = turn * Vec3(i % 6 + random.uniform(0, 0.5), i / 6 + random.uniform(0, 0.5), 0);
      m.means.push_back(p);
      if (i % 6 == 5 || i >= 24) continue;
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

}  // namespace
}  // namespace gpsrecon
