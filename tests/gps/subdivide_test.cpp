// Identities of the Gaussian-product surface.

#include <gmock/gmock.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <gpsrecon/gps/subdivide.h>
#include <gtest/gtest.h>

#include <cstring>

#include "support/covmeshes.h"
#include "support/same_bytes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

Mesh open_irregular_mesh() {
  return with_holes(irregular_sphere(21), 7);
}

TEST(Dual, MapsBothWays) {
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const Gaussian g{random.vector(), random.covariance(1e-3, 1)};
    const Gaussian back = from_dual(to_dual(g));
    EXPECT_LT((back.mean - g.mean).norm(), 1e-12);
    EXPECT_LT((back.covariance.matrix() - g.covariance.matrix()).norm(), 1e-12 * g.covariance.trace());
    const DualMap map(to_dual(g));
    const Vec3 n = random.vector();
    EXPECT_NEAR(n.dot(map.covariance_times(n)), g.covariance.quadratic_form(n), 1e-12);
  }
}

TEST(Dual, IsThePolynomialOfTheSquaredMahalanobisDistance) {
  Random random(5);
  const Gaussian g{random.vector(), random.covariance(0.1, 1)};
  const DualPoint q = to_dual(g);
  const Mat3 precision = g.covariance.matrix().inverse();
  const double constant = g.mean.dot(precision * g.mean);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 x = random.vector();
    const double distance = (x - g.mean).dot(precision * (x - g.mean));
    EXPECT_NEAR(quadratic_part(q).quadratic_form(x) - 2 * linear_part(q).dot(x) + constant, distance, 1e-12);
  }
}

TEST(Dual, TangentIsTheDerivativeOfTheMap) {
  Random random(6);
  const DualPoint a = to_dual({random.vector(), random.covariance(0.1, 1)});
  const DualPoint b = to_dual({random.vector(), random.covariance(0.1, 1)});
  const double h = 1e-5;
  const auto at = [&](double t) { return from_dual(DualPoint((1 - t) * a + t * b)).mean; };
  const Vec3 difference = (at(0.5 + h) - at(0.5 - h)) / (2 * h);
  EXPECT_LT((DualMap(0.5 * (a + b)).tangent(b - a) - difference).norm(), 1e-8);
}

TEST(Subdivide, EqualCovariancesGiveTheLinearScheme) {
  const Mesh mesh = open_irregular_mesh();
  const LimitSurface surface(mesh.faces, mesh.positions.size(), 2);
  const std::vector<Vec3> linear = surface.to_samples<Vec3>(mesh.positions);
  const CovMesh control = with_equal_covariances(mesh, Random(3).covariance(0.1, 1));
  EXPECT_LT(max_distance(subdivide(control, {.levels = 2}).positions, linear), 1e-13);
}

TEST(Subdivide, CommutesWithAffineMaps) {
  for (const bool limit : {true, false}) {
    const CovMesh control = with_random_covariances(open_irregular_mesh(), 11);
    const SubdivideOptions options{.levels = 2, .limit = limit};
    const Mesh surface = subdivide(control, options);
    Random random(12);
    for (int trial = 0; trial < 6; ++trial) {
      Mat3 a = random.matrix() + 0.5 * random.rotation();
      if ((a.determinant() < 0) != (trial % 2 == 1)) a.col(0) *= -1;  // every second one a reflection
      if (std::abs(a.determinant()) < 0.05) continue;
      const Vec3 shift = random.vector();
      CovMesh moved = control;
      for (Vec3& mean : moved.vertices.means) mean = a * mean + shift;
      for (Sym3& covariance : moved.vertices.covariances) covariance = congruence(a, covariance);
      const Mesh mapped = subdivide(moved, options);
      const Mat3 on_normals = a.determinant() * a.inverse().transpose();
      for (std::size_t v = 0; v < mapped.positions.size(); ++v) {
        ASSERT_LT((mapped.positions[v] - (a * surface.positions[v] + shift)).norm(), 1e-11);
        // Faces keep their order, so a reflection turns the side they are seen from.
        ASSERT_LT((mapped.normals[v] - (on_normals * surface.normals[v]).normalized()).norm(), 1e-8);
      }
    }
  }
}

TEST(Subdivide, IgnoresAGlobalFactorOnTheCovariances) {
  const CovMesh control = with_random_covariances(open_irregular_mesh(), 13);
  const Mesh surface = subdivide(control, {.levels = 2});
  const auto scaled_by = [&](double factor) {
    CovMesh scaled = control;
    for (Sym3& covariance : scaled.vertices.covariances) covariance *= factor;
    return subdivide(scaled, {.levels = 2});
  };
  for (const double power_of_two : {0x1p-40, 0x1p-3, 0x1p1, 0x1p60}) {
    const Mesh same = scaled_by(power_of_two);
    EXPECT_TRUE(same_bytes(same.positions, surface.positions));
    EXPECT_TRUE(same_bytes(same.normals, surface.normals));
    for (std::size_t v = 0; v < same.sigma.size(); ++v)
      EXPECT_NEAR(same.sigma[v], std::sqrt(power_of_two) * surface.sigma[v], 1e-12 * std::sqrt(power_of_two));
  }
  EXPECT_LT(max_distance(scaled_by(1000).positions, surface.positions), 1e-12);
}

TEST(Subdivide, ScalesExactlyByPowersOfTwo) {
  const CovMesh control = with_random_covariances(open_irregular_mesh(), 14);
  CovMesh scaled = control;
  for (Vec3& mean : scaled.vertices.means) mean *= 0x1p20;
  for (Sym3& covariance : scaled.vertices.covariances) covariance *= 0x1p40;
  const Mesh a = subdivide(control, {.levels = 2}), b = subdivide(scaled, {.levels = 2});
  for (std::size_t v = 0; v < a.positions.size(); ++v) {
    ASSERT_EQ(Vec3(a.positions[v] * 0x1p20), b.positions[v]);
    ASSERT_EQ(a.normals[v], b.normals[v]);
    ASSERT_EQ(a.sigma[v] * 0x1p20, b.sigma[v]);
  }
}

TEST(Subdivide, ReproducesPlanes) {
  Mesh flat = grid(6, 5);
  Random random(15);
  for (Vec3& p : flat.positions) p += Vec3(0.3 * random.uniform(-1, 1), 0.3 * random.uniform(-1, 1), 0);
  const Mat3 rotation = random.rotation();
  const Vec3 normal = rotation.col(2), shift(1, 2, 3);
  std::vector<Sym3> covariances;
  for (Vec3& p : flat.positions) {
    p = rotation * p + shift;
    // The plane's normal is an eigenvector; the two others turn freely in the plane.
    const double angle = random.uniform(0, 3), c = std::cos(angle), s = std::sin(angle);
    const Vec3 x = c * rotation.col(0) + s * rotation.col(1), y = normal.cross(x);
    covariances.push_back(random.uniform(0.1, 1) * Sym3::outer(x) + random.uniform(0.1, 1) * Sym3::outer(y) +
                          random.uniform(1e-4, 1) * Sym3::outer(normal));
  }
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp}) {
    const Mesh surface = subdivide(with_rules(covariance_mesh(flat, covariances), {.corners = corners}));
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      EXPECT_NEAR((surface.positions[v] - shift).dot(normal), 0, 1e-11);
      EXPECT_LT((surface.normals[v] - normal).norm(), 1e-9);
    }
  }
}

TEST(Subdivide, LimitPositionsAndNormalsAreThoseOfDeepRefinement) {
  const CovMesh control = with_random_covariances(irregular_sphere(22, 10), 16, 0.1, 1);
  const Mesh limit = subdivide(control, {.levels = 1});
  const Mesh deep = subdivide(control, {.levels = 6, .limit = false});
  const Mesh one_less = subdivide(control, {.levels = 5, .limit = false});
  // Vertices keep their index at every level. The distance to the limit falls at least by 0.4 per level.
  for (std::size_t v = 0; v < limit.positions.size(); ++v) {
    const double far = (one_less.positions[v] - limit.positions[v]).norm();
    const double near = (deep.positions[v] - limit.positions[v]).norm();
    EXPECT_LT(near, 0.45 * far + 1e-12);
    EXPECT_LT(near, 5e-3);
  }
  // Limit points do not depend on the level they are computed at, nor do normals.
  const Mesh other = subdivide(control, {.levels = 3});
  for (std::size_t v = 0; v < limit.positions.size(); ++v) {
    EXPECT_LT((other.positions[v] - limit.positions[v]).norm(), 1e-12);
    EXPECT_LT((other.normals[v] - limit.normals[v]).norm(), 1e-10);
    EXPECT_NEAR(other.sigma[v], limit.sigma[v], 1e-12);
  }
}

TEST(Subdivide, LimitPointsDoNotDependOnTheLevelAtBoundaries) {
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp})
    for (const LoopWeights weights : {LoopWeights::loop, LoopWeights::warren}) {
      const CovMesh control = with_random_covariances(grid(5, 4), 17, 0.05, 1);
      const Mesh coarse = subdivide(with_rules(control, {.weights = weights, .corners = corners}), {.levels = 0});
      const Mesh fine = subdivide(with_rules(control, {.weights = weights, .corners = corners}), {.levels = 4});
      for (std::size_t v = 0; v < coarse.positions.size(); ++v) {
        EXPECT_LT((fine.positions[v] - coarse.positions[v]).norm(), 1e-12);
        EXPECT_LT((fine.normals[v] - coarse.normals[v]).norm(), 1e-9);
      }
    }
}

TEST(Subdivide, NormalsAreUnitAndOnTheSideOfTheFaces) {
  for (const Mesh& mesh : {irregular_sphere(23), with_holes(irregular_sphere(24, 60, 0), 7), torus(9, 6)})
    for (const bool limit : {true, false}) {
      const Mesh surface = subdivide(with_equal_covariances(mesh, Sym3::identity()), {.levels = 3, .limit = limit});
      const Connectivity topology = triangle_connectivity(mesh.faces, mesh.positions.size());
      std::vector<Vec3> faces_around(surface.positions.size(), Vec3::Zero());
      for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const auto face = surface.faces[f];
        const Vec3& a = surface.positions[face[0]];
        const Vec3 n = (surface.positions[face[1]] - a).cross(surface.positions[face[2]] - a);
        for (const Index v : face) faces_around[v] += n;
      }
      for (std::size_t v = 0; v < surface.normals.size(); ++v) {
        ASSERT_NEAR(surface.normals[v].norm(), 1, 1e-14);
        // On the boundary from six faces on Loop's rules leave no tangent plane.
        const bool smooth =
            v >= mesh.positions.size() || topology.face_count[v] < 6 || !topology.on_boundary(static_cast<Index>(v));
        ASSERT_GT(surface.normals[v].dot(faces_around[v].normalized()), smooth ? 0.7 : 0.0);
      }
    }
}

TEST(Subdivide, SigmaIsTheDeviationAlongTheNormalWithoutTheKernel) {
  // Equal covariances stay what they are at every vertex.
  const Sym3 covariance = Random(18).covariance(0.01, 0.04);
  CovMesh control = with_equal_covariances(torus(9, 6), covariance);
  const double kernel_variance = eigen_decomposition(covariance).values[1];
  control.vertices.sigma0 = std::sqrt(kernel_variance);
  const Mesh surface = subdivide(control, {.levels = 2});
  std::size_t clamped = 0;
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const double variance = covariance.quadratic_form(surface.normals[v]) - kernel_variance;
    clamped += variance < 0 ? 1 : 0;
    EXPECT_NEAR(surface.sigma[v], std::sqrt(std::max(0.0, variance)), 1e-8);
  }
  EXPECT_GT(clamped, 0u);
  EXPECT_LT(clamped, surface.positions.size());
}

TEST(Subdivide, SphereConvergesQuadratically) {
  std::vector<double> position_errors, normal_errors;
  std::string table;
  for (int resolution = 2; resolution <= 5; ++resolution) {
    const CovMesh control = infer_covariances(sphere(resolution)).mesh;
    const Mesh surface = subdivide(control, {.levels = 2});
    double position_error = 0, normal_error = 0;
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      position_error = std::max(position_error, std::abs(surface.positions[v].norm() - 1));
      normal_error = std::max(normal_error, (surface.normals[v] - surface.positions[v].normalized()).norm());
    }
    position_errors.push_back(position_error);
    normal_errors.push_back(normal_error);
    table += std::to_string(control.vertices.size()) + " control vertices: position " + std::to_string(position_error) +
             ", normal " + std::to_string(normal_error) + "\n";
  }
  SCOPED_TRACE(table);
  // Four times the vertices: a quarter of the position error in the limit, half of that of the normals.
  for (std::size_t k = 1; k < position_errors.size(); ++k) {
    EXPECT_LT(position_errors[k], position_errors[k - 1] / 2.5);
    EXPECT_LT(normal_errors[k], normal_errors[k - 1] / 1.8);
  }
  EXPECT_LT(position_errors[3], position_errors[2] / 3.5);
}

TEST(Subdivide, IsTheSameForAnyNumberOfThreads) {
  const CovMesh control = with_random_covariances(torus(60, 40), 19);
  RunContext context;
  context.threads = 1;
  const Mesh one = subdivide(control, {}, context);
  EXPECT_GT(one.positions.size(), 4 * parallel_block_size);
  for (const int threads : {2, 4, 8}) {
    context.threads = threads;
    const Mesh many = subdivide(control, {}, context);
    EXPECT_EQ(many.faces, one.faces);
    EXPECT_TRUE(same_bytes(many.positions, one.positions));
    EXPECT_TRUE(same_bytes(many.normals, one.normals));
    EXPECT_TRUE(same_bytes(many.sigma, one.sigma));
  }
}

TEST(Subdivide, KeepsPrecisionForFlatGaussiansFarApart) {
  // Thin discs on the plane z = 0: every vertex must stay on it, and move inside it as the scheme says.
  const Mesh flat = grid(8, 8);
  const CovMesh control = with_equal_covariances(flat, Sym3::diagonal(1, 1, 1e-10));
  const LimitSurface surface(flat.faces, flat.positions.size(), 2);
  EXPECT_LT(max_distance(subdivide(control, {.levels = 2}).positions, surface.to_samples<Vec3>(flat.positions)), 1e-12);
  const Mat3 rotation = Random(20).rotation();
  CovMesh turned = control;
  for (Vec3& mean : turned.vertices.means) mean = rotation * mean;
  for (Sym3& c : turned.vertices.covariances) c = congruence(rotation, Sym3::diagonal(1, 1, 1e-6));
  std::vector<Vec3> expected = surface.to_samples<Vec3>(turned.vertices.means);
  EXPECT_LT(max_distance(subdivide(turned, {.levels = 2}).positions, expected), 1e-8);
}

TEST(Subdivide, KeepsPrecisionFarFromTheOrigin) {
  const CovMesh control = with_random_covariances(open_irregular_mesh(), 26, 1e-5, 1);
  CovMesh far = control;
  const Vec3 shift(0x1p20, -0x1p21, 0x1p22);
  for (Vec3& mean : far.vertices.means) mean += shift;
  // The means themselves lose 2^-31 at such coordinates, and the map to the surface enlarges that.
  const std::vector<Vec3> near = subdivide(control, {.levels = 2}).positions;
  std::vector<Vec3> back = subdivide(far, {.levels = 2}).positions;
  for (Vec3& p : back) p -= shift;
  EXPECT_LT(max_distance(back, near), 1e-7);
}

TEST(Subdivide, SurvivesMeshesWithoutTangentPlanes) {
  CovMesh pillow = with_random_covariances(mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}), 1);
  CovMesh needle = with_equal_covariances(mesh_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}), Sym3::identity());
  CovMesh point = with_equal_covariances(mesh_of({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}), Sym3::identity());
  CovMesh loose = with_random_covariances(mesh_of({{0, 0, 0}, {1, 0, 0}}, {}), 2);
  for (const CovMesh& mesh : {pillow, needle, point, loose})
    for (int levels = 0; levels <= 2; ++levels) {
      const Mesh surface = subdivide(mesh, {.levels = levels});
      for (std::size_t v = 0; v < surface.positions.size(); ++v) {
        EXPECT_TRUE(surface.positions[v].allFinite());
        EXPECT_NEAR(surface.normals[v].norm(), 1, 1e-12);
        EXPECT_GE(surface.sigma[v], 0);
      }
    }
  // A vertex without faces has the thin axis of its Gaussian for normal.
  const Mesh kept = subdivide(loose, {.levels = 2});
  EXPECT_EQ(kept.positions.size(), 2u);
  for (std::size_t v = 0; v < 2; ++v) {
    EXPECT_LT((kept.positions[v] - loose.vertices.means[v]).norm(), 1e-14);
    const double smallest = eigen_decomposition(loose.vertices.covariances[v]).values[0];
    EXPECT_NEAR(kept.sigma[v], std::sqrt(smallest), 1e-12);
  }
  EXPECT_TRUE(subdivide(CovMesh{}).positions.empty());
}

TEST(Subdivide, TakesTheNormalOfTheFacesWhereTangentsAreParallel) {
  // Two faces at a boundary vertex (0) whose inner edge is parallel to the chord of the boundary.
  const Mesh mesh =
      mesh_of({{0, 0, 0}, {2, 1, 0.5}, {1, 0, 0}, {-1, 1, 0.5}, {4, 0, 2}}, {{0, 1, 2}, {0, 2, 3}, {2, 1, 4}});
  const Mesh surface = subdivide(with_equal_covariances(mesh, Sym3::identity()), {.levels = 0});
  const std::vector<Vec3>& p = surface.positions;
  const Vec3 area = (p[1] - p[0]).cross(p[2] - p[0]) + (p[2] - p[0]).cross(p[3] - p[0]);
  ASSERT_GT(area.norm(), 0.01);
  EXPECT_LT((surface.normals[0] - area.normalized()).norm(), 1e-12);
}

TEST(Subdivide, ChecksItsArguments) {
  const CovMesh control = with_equal_covariances(tetrahedron(), Sym3::identity());
  EXPECT_THROW(subdivide(control, {.levels = -1}), OptionError);
  EXPECT_THROW(subdivide(control, {.levels = 9}), OptionError);
  try {
    subdivide(control, {.levels = 11});
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("levels"), testing::HasSubstr("11")));
  }
  EXPECT_THROW(LimitSurface(torus(150, 120).faces, 18000, 8), OptionError);  // 2.4e9 faces
  EXPECT_THROW(LimitSurface(control.faces, 4, -1), OptionError);
  EXPECT_THROW(LimitSurface(control.faces, 4, 1).evaluate(Mixture{}), InvariantError);
  CovMesh broken = control;
  broken.vertices.covariances[2] = Sym3::diagonal(1, 1, -1);
  EXPECT_THROW(subdivide(broken, {.levels = 2}), InvariantError);
  const std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  EXPECT_THROW(subdivide(control, {}, context), Cancelled);
}

TEST(Subdivide, KeepsTheFrame) {
  CovMesh control = with_equal_covariances(tetrahedron(), Sym3::identity());
  control.vertices.frame = {Vec3(1, 2, 3), 7};
  EXPECT_EQ(subdivide(control, {.levels = 2}).frame, control.vertices.frame);
}

TEST(LevelForEdgeLength, HalvesTheMeanEdge) {
  const CovMesh control = with_equal_covariances(octahedron(), Sym3::identity());  // every edge has length sqrt 2
  const double edge = std::sqrt(2.0) * (1 + 1e-12);
  EXPECT_EQ(level_for_edge_length(control, edge), 0);
  EXPECT_EQ(level_for_edge_length(control, edge / 1.01), 1);
  EXPECT_EQ(level_for_edge_length(control, edge / 2), 1);
  EXPECT_EQ(level_for_edge_length(control, edge / 2.5), 2);
  EXPECT_EQ(level_for_edge_length(control, edge / 4), 2);
  EXPECT_EQ(level_for_edge_length(control, edge / 100), 3);
  EXPECT_EQ(level_for_edge_length(control, edge / 100, 5), 5);
  EXPECT_EQ(level_for_edge_length(control, 0), 3);
  EXPECT_EQ(level_for_edge_length(CovMesh{}, 1), 0);
  // Interior edges count once, like boundary edges.
  const CovMesh two = with_equal_covariances(
      mesh_of({{0, 0, 0}, {8, 0, 0}, {4, 3, 0}, {4, -3, 0}}, {{0, 1, 2}, {1, 0, 3}}), Sym3::identity());
  EXPECT_EQ(level_for_edge_length(two, 28.0 / 5 + 1e-9), 0);
  EXPECT_EQ(level_for_edge_length(two, 28.0 / 5 - 1e-9), 1);
}

}  // namespace
}  // namespace gpsrecon::test
