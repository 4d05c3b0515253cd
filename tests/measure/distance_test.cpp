#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/measure/distance.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <limits>
#include <numeric>

#include "support/meshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

double to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double length2 = (b - a).squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
  return ((1 - t) * a + t * b - p).norm();
}

/// By the normal equations of the parametrised triangle, and all three edges.
double to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  double best = std::min({to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a)});
  const Vec3 u = b - a, v = c - a, w = p - a;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
  if (det > 1e-14 * uu * vv) {
    const double s = (vv * u.dot(w) - uv * v.dot(w)) / det, t = (uu * v.dot(w) - uv * u.dot(w)) / det;
    if (s >= 0 && t >= 0 && s + t <= 1) best = std::min(best, (a + s * u + t * v - p).norm());
  }
  return best;
}

double to_face(const Vec3& p, const Mesh& mesh, std::size_t f) {
  double best = std::numeric_limits<double>::infinity();
  for_each_triangle(mesh.faces[f], [&](Index a, Index b, Index c) {
    best = std::min(best, to_triangle(p, mesh.positions[a], mesh.positions[b], mesh.positions[c]));
  });
  return best;
}

double brute_force(const Vec3& p, const Mesh& mesh) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) best = std::min(best, to_face(p, mesh, f));
  return best;
}

void expect_exact(const Mesh& mesh, const std::vector<Vec3>& points, double tolerance) {
  const std::vector<ClosestPoint> found = SurfaceDistance(mesh).distances(points);
  ASSERT_EQ(found.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_NEAR(found[i].distance, brute_force(points[i], mesh), tolerance) << i;
    ASSERT_NEAR((found[i].point - points[i]).norm(), found[i].distance, tolerance) << i;
    ASSERT_LT(found[i].face, mesh.faces.size());
    ASSERT_NEAR(to_face(found[i].point, mesh, found[i].face), 0, tolerance) << i;
  }
}

/// Triangles of all shapes, some without area.
Mesh soup(std::size_t n) {
  Random random(1);
  Mesh mesh;
  for (std::size_t f = 0; f < n; ++f) {
    const Index v = static_cast<Index>(mesh.positions.size());
    const Vec3 a = random.vector();
    const Vec3 d = 0.2 * random.vector();
    mesh.positions.push_back(a);
    mesh.positions.push_back(a + d);
    switch (f % 10) {
      case 0:
        mesh.positions.push_back(a + 0.25 * d);
        break;  // collinear
      case 1:
        mesh.positions.push_back(a + d);
        break;  // two corners coincide
      case 2:
        mesh.positions.push_back(a + 0.5 * d + 1e-7 * random.vector());
        break;  // a needle
      case 3:
        mesh.positions.push_back(a + 0.5 * d + 1e-11 * random.vector());
        break;  // a finer one
      default:
        mesh.positions.push_back(a + 0.2 * random.vector());
    }
    if (f % 10 == 4)
      mesh.faces.add(v, v, v + 1);  // a repeated corner
    else
      mesh.faces.add(v, v + 1, v + 2);
  }
  return mesh;
}

TEST(Distance, AgreesWithBruteForce) {
  const Mesh mesh = soup(700);
  expect_exact(mesh, Random(2).vectors(600, -(1.2), 1.2), 1e-12);
  expect_exact(mesh, Random(3).vectors(100, -(50), 50), 1e-12);
}

TEST(Distance, AgreesWithBruteForceForAnyNumberOfTriangles) {
  for (std::size_t n = 1; n <= 20; ++n) expect_exact(soup(n), Random(4).vectors(50, -(1), 1), 1e-12);
}

TEST(Distance, AgreesWithBruteForceCloseToTheSurface) {
  const Mesh mesh = sphere(3);
  Random random(5);
  for (const double height : {1e-3, 1e-5, 1e-7, 1e-9, 1e-12}) {
    std::vector<Vec3> points(300);
    for (Vec3& p : points) p = (1 + random.uniform(-height, height)) * random.vector().normalized();
    expect_exact(mesh, points, 1e-14);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] = mesh.positions[i % mesh.positions.size()] + height * random.vector();
    expect_exact(mesh, points, 1e-14);
  }
}

TEST(Distance, SmallTrianglesAreMeasuredWellFromFarAway) {
  Mesh mesh = sphere(2);
  for (Vec3& p : mesh.positions) p = 1e-3 * p;
  std::vector<Vec3> points = Random(6).vectors(200, -(1e6), 1e6);
  const std::vector<ClosestPoint> found = SurfaceDistance(mesh).distances(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(found[i].distance / points[i].norm(), 1, 1e-8);
    EXPECT_NEAR(found[i].point.norm(), 1e-3, 1e-4);  // the place on the sphere is still meaningful
    EXPECT_GT(found[i].point.normalized().dot(points[i].normalized()), 0.9);
  }
}

TEST(Distance, PolygonsAreFansOfTriangles) {
  const Mesh quads = quad_torus(30, 20, 2, 0.7);
  Mesh triangles = quads;
  triangles.faces = {};
  for (std::size_t f = 0; f < quads.faces.size(); ++f) {
    const auto q = quads.faces[f];
    triangles.faces.add(q[0], q[1], q[2]);
    triangles.faces.add(q[0], q[2], q[3]);
  }
  const std::vector<Vec3> points = Random(7).vectors(2000, -(3), 3);
  const auto a = SurfaceDistance(quads).distances(points), b = SurfaceDistance(triangles).distances(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(a[i].distance, b[i].distance);
    EXPECT_EQ(a[i].face, b[i].face / 2);
  }
  EXPECT_EQ(SurfaceDistance(quads).triangle_count(), triangles.faces.size());
}

TEST(Distance, IsZeroOnTheSurface) {
  const Mesh mesh = sphere(4);
  Random random(8);
  std::vector<Vec3> points;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const double r = std::sqrt(random.uniform()), s = random.uniform();
    const auto face = mesh.faces[f];
    points.push_back((1 - r) * mesh.positions[face[0]] + r * (1 - s) * mesh.positions[face[1]] +
                     r * s * mesh.positions[face[2]]);
  }
  points.insert(points.end(), mesh.positions.begin(), mesh.positions.end());
  for (const ClosestPoint& c : SurfaceDistance(mesh).distances(points)) EXPECT_LT(c.distance, 1e-15);
}

TEST(Distance, ApproachesTheSphereWithTheSquareOfTheEdge) {
  std::vector<Vec3> points = Random(9).vectors(5000, -(1), 1);
  for (Vec3& p : points) p.normalize();
  double previous = 0;
  std::printf("  level   faces   max distance of the sphere   ratio\n");
  for (int level = 2; level <= 6; ++level) {
    const Mesh mesh = sphere(level);
    double worst = 0;
    for (const ClosestPoint& c : SurfaceDistance(mesh).distances(points)) worst = std::max(worst, c.distance);
    std::printf("  %5d %7zu %28.3e %7.3f\n", level, mesh.faces.size(), worst, previous / worst);
    if (previous > 0) {
      EXPECT_NEAR(previous / worst, 4, 0.4);
    }
    previous = worst;
  }
}

TEST(Distance, MovesWithTheSurface) {
  const Mesh mesh = quad_torus(40, 25, 2, 0.7);
  const Eigen::Isometry3d motion = some_motion();
  std::vector<Vec3> points = Random(10).vectors(2000, -(3), 3);
  const auto before = SurfaceDistance(mesh).distances(points);
  for (Vec3& p : points) p = motion * p;
  const auto after = SurfaceDistance(moved(mesh, motion)).distances(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(after[i].distance, before[i].distance, 1e-14);
    // A point in equal distance of two places may go either way; random points do not.
    EXPECT_LT((after[i].point - motion * before[i].point).norm(), 1e-9);
  }
}

TEST(Distance, ScalesExactlyWithPowersOfTwo) {
  const Mesh mesh = quad_torus(40, 25, 2, 0.7);
  const std::vector<Vec3> points = Random(11).vectors(2000, -(3), 3);
  const auto expected = SurfaceDistance(mesh).distances(points);
  for (const int exponent : {1, 37, -60, 300, -300}) {
    const double factor = std::ldexp(1.0, exponent);
    Mesh scaled_mesh = mesh;
    for (Vec3& p : scaled_mesh.positions) p *= factor;
    std::vector<Vec3> scaled_points = points;
    for (Vec3& p : scaled_points) p *= factor;
    const auto found = SurfaceDistance(scaled_mesh).distances(scaled_points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(found[i].distance, expected[i].distance * factor) << exponent;
      ASSERT_EQ(found[i].face, expected[i].face) << exponent;
    }
  }
}

TEST(Distance, KeepsItsAccuracyFarFromTheOrigin) {
  const Vec3 offset(600000, 5000000, -200);
  Mesh mesh = sphere(3);
  std::vector<Vec3> points = Random(12).vectors(1000, -(1.5), 1.5);
  const auto round = [](Vec3& p) { p = (p * 0x1p20).array().round() * 0x1p-20; };  // exact after the shift, too
  for (Vec3& p : mesh.positions) round(p);
  for (Vec3& p : points) round(p);
  const auto near = SurfaceDistance(mesh).distances(points);
  for (Vec3& p : mesh.positions) p += offset;
  for (Vec3& p : points) p += offset;
  const auto far = SurfaceDistance(mesh).distances(points);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(far[i].distance, near[i].distance, 1e-15);
}

TEST(Distance, SameBytesForAnyNumberOfThreads) {
  const Mesh mesh = sphere(5);
  const std::vector<Vec3> points = Random(13).vectors(20000, -(1.2), 1.2);
  RunContext one;
  one.threads = 1;
  const auto expected = SurfaceDistance(mesh, one).distances(points, one);
  for (const int threads : {2, 4, 7}) {
    RunContext context;
    context.threads = threads;
    const auto found = SurfaceDistance(mesh, context).distances(points, context);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(found[i].distance, expected[i].distance);
      ASSERT_EQ(found[i].point, expected[i].point);
      ASSERT_EQ(found[i].face, expected[i].face);
    }
  }
}

TEST(Distance, DoesNotDependOnTheOtherQueries) {
  const Mesh mesh = sphere(4);
  const std::vector<Vec3> points = Random(14).vectors(5000, -(1.2), 1.2);
  const SurfaceDistance surface(mesh);
  const auto together = surface.distances(points);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_NEAR(surface.closest(points[i]).distance, together[i].distance, 1e-15) << i;
}

TEST(Distance, OfEquallyNearFacesNamesOne) {
  const SurfaceDistance surface(octahedron()), again(octahedron());
  const auto face = [&](const Vec3& query) {
    const Index f = surface.closest(query).face;
    EXPECT_EQ(f, again.closest(query).face);
    return f;
  };
  EXPECT_THAT(face({2, 0, 0}), testing::AnyOf(0u, 3u, 4u, 7u));  // at a corner of all four
  EXPECT_THAT(face({-2, 0, 0}), testing::AnyOf(1u, 2u, 5u, 6u));
  EXPECT_THAT(face({0, 0, -2}), testing::AnyOf(4u, 5u, 6u, 7u));
}

TEST(Distance, ADistantQueryCostsTheNextNoDigits) {
  const Mesh mesh = sphere(2);
  const SurfaceDistance surface(mesh);
  Random random(15);
  for (int i = 0; i < 500; ++i) {
    const Vec3 distant = 3e8 * random.vector();
    const Vec3 close = surface.closest(distant).point + 1e-7 * random.vector();
    const std::vector<Vec3> points{distant, close};
    EXPECT_NEAR(surface.distances(points)[1].distance, brute_force(close, mesh), 1e-14) << i;
  }
}

TEST(Distance, CopesWithManyEqualTrianglesAndWithPoints) {
  Mesh mesh = square(0);
  for (int i = 0; i < 1000; ++i) mesh.faces.add(0, 1, 2);
  EXPECT_DOUBLE_EQ(SurfaceDistance(mesh).closest({0.9, 0.2, 0.5}).distance, 0.5);

  Mesh point;
  point.positions = {{3, 4, 0}};
  for (int i = 0; i < 10; ++i) point.faces.add(0, 0, 0);
  const ClosestPoint c = SurfaceDistance(point).closest({0, 0, 0});
  EXPECT_DOUBLE_EQ(c.distance, 5);
  EXPECT_EQ(c.point, Vec3(3, 4, 0));
  EXPECT_EQ(SurfaceDistance(point).closest({3, 4, 0}).distance, 0);
}

TEST(Distance, RefusesWhatHasNoDistance) {
  const std::vector<Vec3> origin{Vec3::Zero()};
  const SurfaceDistance empty{Mesh{}};
  EXPECT_TRUE(empty.empty());
  EXPECT_TRUE(empty.distances({}).empty());
  EXPECT_THROW(empty.distances(origin), InvariantError);

  Mesh broken = octahedron();
  broken.faces.add(0, 1, 6);
  EXPECT_THROW(SurfaceDistance{broken}, InvariantError);
  Mesh not_finite = octahedron();
  not_finite.positions[2].y() = std::nan("");
  EXPECT_THROW(SurfaceDistance{not_finite}, InvariantError);
  not_finite = octahedron();
  not_finite.positions.push_back(Vec3::Constant(std::nan("")));  // unused: no harm
  EXPECT_DOUBLE_EQ(SurfaceDistance(not_finite).closest({3, 0, 0}).distance, 2);

  const std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(0, std::numeric_limits<double>::infinity(), 0)};
  EXPECT_THROW(SurfaceDistance(octahedron()).distances(points), InvariantError);

  for (const double far : {1e60, 1e69}) {
    const std::vector<Vec3> point{Vec3(0.1 * far, far, -far)};
    EXPECT_NEAR(SurfaceDistance(octahedron()).distances(point)[0].distance / point[0].norm(), 1, 1e-12);
  }
  for (const double far : {1e75, 1e200, 1e308}) {
    const std::vector<Vec3> point{Vec3(far, 0, -far)};
    EXPECT_THROW(SurfaceDistance(octahedron()).distances(point), InvariantError);
  }

  const std::atomic<bool> stop{true};
  RunContext context;
  context.cancel = &stop;
  EXPECT_THROW(SurfaceDistance(octahedron()).distances(origin, context), Cancelled);
}

}  // namespace
}  // namespace gpsrecon::test
