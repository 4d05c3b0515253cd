#include <gtest/gtest.h>

#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/triangulate/front.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

constexpr double pi = std::numbers::pi;

/// Isotropic Gaussians at given places, which all overlap, a surface to add triangles to, and judges of it.
struct Scene {
  Mixture mixture;
  OverlapGraph graph;
  Sheets sheets;
  GrowingSurface surface;
  TriangleJudge strict, lenient;

  Scene(const Scene&) = delete;
  explicit Scene(const std::vector<Vec3>& points, double min_dihedral = pi / 6)
      : mixture(around(points)),
        graph(overlap_graph(mixture, 1e-9, {})),
        sheets(std::vector<Vec3>(points.size(), Vec3::Zero())),
        surface(mixture.means),
        strict(graph, sheets, surface, min_dihedral),
        lenient(graph, sheets, surface, min_dihedral, true) {}

  static Mixture around(const std::vector<Vec3>& points) {
    Mixture m;
    m.means = points;
    m.covariances.assign(points.size(), Sym3::identity(1));
    m.weights.assign(points.size(), 1.0);
    return m;
  }
};

Vec3 on_circle(double degrees, double radius = 1) {
  return {radius * std::cos(degrees * pi / 180), radius * std::sin(degrees * pi / 180), 0};
}

TEST(TriangleJudge, OverlapIsTheProductOfThePairs) {
  Scene s({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 2, 0), Vec3(40, 0, 0)});
  // Equal isotropic Gaussians: ln BC = -d²/8.
  EXPECT_NEAR(*s.strict.log_overlap(0, 1, 2), -(1 + 4 + 5) / 8.0, 1e-14);
  EXPECT_FALSE(s.strict.log_overlap(0, 1, 3).has_value());
}

TEST(TriangleJudge, AngleToTheNeighbourAcrossAnEdge) {
  for (const double degrees : {0.0, 40.0, 90.0, 149.0, 151.0, 180.0}) {
    // A triangle on the left of 0 -> 1 and one on the right, turned up by the given angle out of the plane.
    const double turn = degrees * pi / 180;
    Scene s({Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(-1, 0.5, 0), Vec3(std::cos(turn), 0.5, std::sin(turn))});
    EXPECT_EQ(*s.strict.dihedral(0, 1, 2), pi);  // without neighbours
    s.surface.add({0, 1, 2});
    const auto angle = s.lenient.dihedral(1, 0, 3);
    if (degrees > 150) {
      EXPECT_FALSE(angle.has_value()) << degrees;
    } else {
      ASSERT_TRUE(angle.has_value()) << degrees;
      EXPECT_NEAR(*angle, pi - turn, 1e-7);
    }
  }
}

TEST(TriangleJudge, SmallestAngleCounts) {
  // A tent: the new triangle in the plane z = 0 meets one neighbour at 90 degrees and one flat.
  Scene s({Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0), Vec3(1, 0, 1), Vec3(-1, 1, 0)});
  s.surface.add({1, 0, 3});
  s.surface.add({0, 2, 4});
  EXPECT_NEAR(*s.lenient.dihedral(0, 1, 2), pi / 2, 1e-12);
}

TEST(TriangleJudge, TakenHalfEdgesAndFlatTriangles) {
  Scene s({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(2, 0, 0), Vec3(0.5, -1, 0)});
  s.surface.add({0, 1, 2});
  EXPECT_FALSE(s.lenient.dihedral(0, 1, 2).has_value());
  EXPECT_FALSE(s.lenient.dihedral(0, 1, 4).has_value());
  EXPECT_FALSE(s.lenient.dihedral(4, 0, 1).has_value());
  EXPECT_TRUE(s.lenient.dihedral(1, 0, 4).has_value());
  EXPECT_FALSE(s.lenient.dihedral(0, 3, 1).has_value());  // on a line
}

/// Vertex 0 in the middle of a hexagon of vertices 1 to 6, and two more above.
std::vector<Vec3> wheel() {
  std::vector<Vec3> points{Vec3::Zero()};
  for (int k = 0; k < 6; ++k) points.push_back(on_circle(60 * k));
  points.insert(points.end(), {Vec3(0, 0, 2), Vec3(1, 0, 2)});
  return points;
}
/// All triangles of the wheel but the one of 6 and 1.
void add_five(Scene& s) {
  for (Index k = 1; k < 6; ++k) s.surface.add({0, k, k + 1});
}

TEST(TriangleJudge, AClosedFanHasNoRoom) {
  Scene s(wheel());
  add_five(s);
  EXPECT_TRUE(s.lenient.dihedral(0, 7, 8).has_value());
  EXPECT_TRUE(s.lenient.dihedral(0, 6, 1).has_value());
  s.surface.add({0, 6, 1});
  EXPECT_FALSE(s.lenient.dihedral(0, 7, 8).has_value());
}

TEST(TriangleJudge, AFanDoesNotCloseBesideAnother) {
  Scene s(wheel());
  add_five(s);
  s.surface.add({0, 7, 8});
  EXPECT_FALSE(s.lenient.dihedral(0, 6, 1).has_value());
  // A triangle that joins two fans of a vertex into one is welcome.
  Scene two(wheel());
  two.surface.add({0, 1, 2});
  two.surface.add({0, 3, 4});
  EXPECT_TRUE(two.lenient.dihedral(0, 2, 3).has_value());
}

TEST(TriangleJudge, NoOverlapAroundAVertex) {
  // A triangle around the origin from 0 to 60 degrees; another from `from` to `to` overlaps it or does not.
  struct Case {
    double from, to;
    bool overlaps;
  };
  for (const Case& c : {Case{90, 150, false}, Case{300, 350, false}, Case{30, 90, true}, Case{330, 30, true},
                        Case{20, 40, true}, Case{300, 80, true}, Case{0.5, 59.5, true}, Case{60.01, 120, false}}) {
    Scene s({Vec3::Zero(), on_circle(0), on_circle(60), on_circle(c.from, 1.5), on_circle(c.to, 1.5), on_circle(0, 0.7),
             on_circle(60, 0.7)});
    s.surface.add({0, 1, 2});
    EXPECT_EQ(s.strict.dihedral(0, 3, 4).has_value(), !c.overlaps) << c.from << " to " << c.to;
    EXPECT_TRUE(s.lenient.dihedral(0, 3, 4).has_value());
    // The other side of a thin sheet may lie over it.
    EXPECT_TRUE(s.strict.dihedral(0, 4, 3).has_value());
    // The very same sector overlaps as well.
    EXPECT_FALSE(s.strict.dihedral(0, 5, 6).has_value());
  }
}

TEST(TriangleJudge, AFlatGaussianShowsOneSide) {
  Scene s({Vec3::Zero(), on_circle(0), on_circle(60), on_circle(120), on_circle(180)});
  s.surface.add({0, 1, 2});
  // Turned over, in another sector: only the sheet of vertex 0 can tell.
  EXPECT_TRUE(s.strict.dihedral(0, 4, 3).has_value());
  for (const double sign : {1.0, -1.0}) {
    s.sheets.normals[0] = sign * Vec3::UnitZ();
    EXPECT_FALSE(s.strict.dihedral(0, 4, 3).has_value());
    EXPECT_TRUE(s.strict.dihedral(0, 3, 4).has_value());
    EXPECT_TRUE(s.lenient.dihedral(0, 4, 3).has_value());
  }
}

TEST(TriangleJudge, TheOuterSideFacesOutward) {
  // Nothing is there yet to agree with.
  Scene s({Vec3::Zero(), on_circle(0), on_circle(60)});
  for (const double sign : {1.0, -1.0}) {
    s.sheets.outer[1] = sign * Vec3::UnitZ();
    EXPECT_EQ(s.strict.dihedral(0, 1, 2).has_value(), sign > 0);
    EXPECT_EQ(s.strict.dihedral(0, 2, 1).has_value(), sign < 0);
    EXPECT_TRUE(s.lenient.dihedral(0, 1, 2).has_value());
    EXPECT_TRUE(s.lenient.dihedral(0, 2, 1).has_value());
  }
  // At right angles either will do.
  s.sheets.outer[1] = Vec3::UnitX();
  EXPECT_TRUE(s.strict.dihedral(0, 1, 2).has_value());
  EXPECT_TRUE(s.strict.dihedral(0, 2, 1).has_value());
}

TEST(Front, StartsOuterSideUp) {
  for (const double sign : {1.0, -1.0}) {
    Scene s({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)});
    s.sheets.outer.assign(4, sign * Vec3::UnitZ());
    grow_front(s.surface, s.graph, s.sheets, {}, {});
    ASSERT_EQ(s.surface.faces().size(), 2U);
    for (Index t = 0; t < 2; ++t) EXPECT_EQ(s.surface.normal(t).z(), sign);
  }
}

TEST(Front, LeavesNoFansThatOnlyTouch) {
  // A triangle that reaches the front in its apex only comes with the one beside it that joins the fans there.
  std::size_t faces = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    test::Random random(70 + seed);
    Mixture m;
    for (int i = 0; i < 80; ++i) {
      m.means.push_back(random.vector(0, 1));
      m.covariances.push_back(test::disc_covariance(random.direction(), 0.25, random.uniform(0.02, 0.25)));
      m.weights.push_back(1);
    }
    GrowingSurface surface(m.means);
    grow_front(surface, overlap_graph(m, 0.01, {}), Sheets(sheet_normals(m, {})), {}, {});
    EXPECT_TRUE(topology(surface.faces(), m.size()).manifold()) << seed;
    faces += surface.faces().size();
  }
  EXPECT_GT(faces, 1000U);
}

TEST(Front, NewPiecesAreOrientedLikeTheSurfaceAround) {
  // A patch of the plane in which everything overlaps, begun with one triangle facing up or down.
  for (const bool up : {true, false})
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      test::Random random(seed);
      std::vector<Vec3> points;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          points.emplace_back(i + random.uniform(-0.3, 0.3), j + random.uniform(-0.3, 0.3), 0);
      Scene s(points);
      s.surface.add(up ? GrowingSurface::Triangle{5, 9, 6} : GrowingSurface::Triangle{5, 6, 9});
      grow_front(s.surface, s.graph, s.sheets, {}, {});
      for (Index t = 0; t < s.surface.faces().size(); ++t) EXPECT_EQ(s.surface.normal(t).z(), up ? 1 : -1);
      EXPECT_EQ(topology(s.surface.faces(), points.size()).components, 1U);
    }
}

TEST(Front, GoesOnFromWhatIsThere) {
  // No seed fits, as only one Gaussian is unused, but the edges of the first triangle have room.
  Scene s({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)});
  s.surface.add({0, 1, 2});
  grow_front(s.surface, s.graph, s.sheets, {}, {});
  EXPECT_EQ(s.surface.faces().size(), 2U);
  EXPECT_TRUE(s.surface.has(2, 1));
}

TEST(Front, GaussiansOfNoSheetDoNotFoldInThePlane) {
  // Isotropic Gaussians tell nothing of sheets: in a plane only the triangles themselves can keep from overlapping.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    test::Random random(seed);
    Mixture m;
    for (int i = 0; i < 14; ++i)
      for (int j = 0; j < 14; ++j)
        m.means.emplace_back(i + random.uniform(-0.45, 0.45), j + random.uniform(-0.45, 0.45), 0);
    m.covariances.assign(m.means.size(), Sym3::identity(0.4));
    m.weights.assign(m.means.size(), 1.0);
    const TriangulateOptions options;
    const OverlapGraph graph = overlap_graph(m, options.min_overlap, {});
    const Sheets sheets(sheet_normals(m, {}));
    EXPECT_EQ(sheets.normals[0], Vec3::Zero());
    GrowingSurface surface(m.means);
    grow_front(surface, graph, sheets, options, {});
    const FaceList faces = surface.faces();
    ASSERT_GT(faces.size(), 300U);
    for (Index t = 0; t < faces.size(); ++t) EXPECT_EQ(surface.normal(t).z(), surface.normal(0).z());
    // Every place in the plane is covered at most once.
    for (int k = 0; k < 500; ++k) {
      const Vec3 x(random.uniform(0, 13), random.uniform(0, 13), 0);
      int covers = 0;
      for (Index t = 0; t < faces.size(); ++t) {
        bool inside = true;
        for (std::size_t e = 0; e < 3; ++e) {
          const Vec3 &a = m.means[faces[t][e]], &b = m.means[faces[t][(e + 1) % 3]];
          inside = inside && (b - a).cross(x - a).z() * surface.normal(0).z() > 0;
        }
        covers += inside ? 1 : 0;
      }
      EXPECT_LE(covers, 1);
    }
  }
}

}  // namespace
}  // namespace gpsrecon
