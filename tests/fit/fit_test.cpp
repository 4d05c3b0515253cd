#include <gmock/gmock.h>
#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/fit/fit.h>
#include <gtest/gtest.h>

#include <atomic>
#include <numbers>

#include "support/connectivity.h"
#include "support/covmeshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::max_distance;
using test::rms_to_unit_sphere;
using test::sphere_cloud;
using test::sphere_mesh;

/// A tilted plane: discs of different sizes over a grid, and the rotation that took it out of z = 0.
struct TiltedPlane {
  CovMesh mesh;
  Mat3 rotation;
};
TiltedPlane tilted_plane(Index cells, bool tilt) {
  test::Random random(3);
  const Mat3 rotation = tilt ? random.rotation() : Mat3::Identity();
  const Mesh grid = test::grid(cells, cells);
  std::vector<Sym3> covariances;
  for (std::size_t v = 0; v < grid.positions.size(); ++v) {
    const double x = random.uniform(0.3, 0.6), y = random.uniform(0.3, 0.6);
    covariances.push_back(congruence(rotation, Sym3::diagonal(x * x, y * y, 0.01)));
  }
  TiltedPlane plane{test::covariance_mesh(grid, covariances), rotation};
  for (Vec3& mean : plane.mesh.vertices.means) mean = rotation * mean;
  return plane;
}

void expect_same_but_means(const CovMesh& a, const CovMesh& b) {
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.vertices.covariances, b.vertices.covariances);
  EXPECT_EQ(a.vertices.weights, b.vertices.weights);
  EXPECT_EQ(a.vertices.sigma0, b.vertices.sigma0);
  EXPECT_EQ(a.vertices.spacing, b.vertices.spacing);
  EXPECT_EQ(a.vertices.frame, b.vertices.frame);
}

/// `measure` of the surface of `rules` of a mesh that was fitted as that of `fitted_by`.
template <class Measure>
double after_fit(const CovMesh& mesh, const PointCloud& cloud, const SurfaceRules& rules, const SurfaceRules& fitted_by,
                 const Measure& measure) {
  const CovMesh fitted = fit(test::with_rules(mesh, fitted_by), cloud, {.refinements = 0}).mesh;
  EXPECT_EQ(fitted.rules, fitted_by);
  return measure(test::with_rules(fitted, rules));
}

TEST(Fit, MovesTheSurfaceOfTheRulesOfTheMesh) {
  const SurfaceRules loop;
  const CovMesh sphere = sphere_mesh(2, 0.97);
  const PointCloud cloud = sphere_cloud(4000);
  // How far the surface lies outside or inside the sphere on the whole: the schemes shrink by different amounts.
  const auto offset = [](const CovMesh& mesh) {
    double sum = 0, count = 0;
    const LimitSurface surface(mesh.faces, mesh.vertices.size(), 3, mesh.rules);
    for (const Vec3& p : surface.evaluate(mesh.vertices).positions) sum += p.norm() - 1, ++count;
    return std::abs(sum / count);
  };
  const SurfaceRules quads{.scheme = Scheme::catmull_clark};
  const double own = after_fit(sphere, cloud, quads, quads, offset);
  EXPECT_LT(own, 0.1 * after_fit(sphere, cloud, quads, loop, offset));
  EXPECT_LT(own, 0.1 * after_fit(sphere, cloud, loop, quads, offset));
  // Warren's weights differ from Loop's at the six vertices of valence four.
  const auto offset_of_irregular = [](const CovMesh& mesh) {
    const LimitSurface surface(mesh.faces, mesh.vertices.size(), 3, mesh.rules);
    const SurfaceSamples samples = surface.evaluate(mesh.vertices);
    double sum = 0;
    for (std::size_t v = 0; v < 6; ++v) sum += std::abs(samples.positions[v].norm() - 1) / 6;
    return sum;
  };
  const SurfaceRules warren{.weights = LoopWeights::warren};
  EXPECT_LT(after_fit(sphere, cloud, warren, warren, offset_of_irregular),
            0.9 * after_fit(sphere, cloud, warren, loop, offset_of_irregular));
  // A shallow bowl under a sheet with two corners of a single face, which the rules keep or round off.
  const auto bowl = [](double x, double y) { return 0.005 * (x * x + y * y); };
  PointCloud points;
  for (double x = -8; x <= 8; x += 0.05)
    for (double y = -4; y <= 4; y += 0.05) points.positions.emplace_back(x, y, bowl(x, y));
  const CovMesh sheet = test::flat_lattice(6);
  const auto offset_of_corners = [&](const CovMesh& mesh) {
    const LimitSurface surface(mesh.faces, mesh.vertices.size(), 2, mesh.rules);
    const SurfaceSamples samples = surface.evaluate(mesh.vertices);
    double largest = 0;
    for (const Vec3& p : {samples.positions.front(), samples.positions[sheet.vertices.size() - 1]})
      largest = std::max(largest, std::abs(p.z() - bowl(p.x(), p.y())));
    return largest;
  };
  const SurfaceRules sharp{.corners = CornerRule::sharp};
  EXPECT_LT(after_fit(sheet, points, sharp, sharp, offset_of_corners),
            0.7 * after_fit(sheet, points, sharp, loop, offset_of_corners));
}

TEST(Fit, RefinementKeepsTheRules) {
  CovMesh mesh = sphere_mesh(0, 0.97);
  mesh.rules = {.scheme = Scheme::catmull_clark, .weights = LoopWeights::warren, .corners = CornerRule::sharp};
  const Fit refined = fit(mesh, sphere_cloud(4000));
  EXPECT_GT(refined.refinements, 0);
  EXPECT_EQ(refined.mesh.rules, mesh.rules);
}

TEST(Fit, ReturnsTheMeshForZeroStepsAndForNoPointsAndNoFaces) {
  const CovMesh mesh = sphere_mesh(2, 0.97);
  CovMesh no_faces = mesh;
  no_faces.faces = {};
  for (const Fit& same : {fit(mesh, sphere_cloud(500), {.steps = 0}), fit(mesh, PointCloud{})}) {
    expect_same_but_means(same.mesh, mesh);
    EXPECT_EQ(same.mesh.vertices.means, mesh.vertices.means);
    EXPECT_EQ(same.steps, 0);
    EXPECT_EQ(same.refinements, 0);
    EXPECT_EQ(same.held_out_points, 0U);
  }
  EXPECT_EQ(fit(no_faces, sphere_cloud(500)).mesh.vertices.means, mesh.vertices.means);
  EXPECT_TRUE(fit(CovMesh{}, PointCloud{}).mesh.vertices.empty());
  EXPECT_TRUE(fit(CovMesh{}, sphere_cloud(500)).mesh.vertices.empty());
}

/// Refined, not refined, and with refinements that noise undoes.
TEST(Fit, HandsOnTheConnectivityOfItsMesh) {
  const CovMesh mesh = sphere_mesh(1, 0.97);
  for (const double noise : {0.0, 0.002, 0.05})
    for (const int steps : {0, 4}) {
      const Fit fitted = fit(mesh, sphere_cloud(4000, noise), {.steps = steps});
      test::expect_connectivity(fitted.connectivity, fitted.mesh.faces, fitted.mesh.vertices.size());
    }
}

TEST(Fit, MovesNothingButTheMeansWithoutRefinements) {
  CovMesh mesh = sphere_mesh(2, 0.97);
  mesh.vertices.sigma0 = 0.01;
  mesh.vertices.spacing = 0.02;
  const Fit fitted = fit(mesh, sphere_cloud(2000), {.refinements = 0});
  expect_same_but_means(fitted.mesh, mesh);
  EXPECT_EQ(fitted.added_vertices, 0U);
  EXPECT_GT(max_distance(fitted.mesh.vertices.means, mesh.vertices.means), 0.01);
}

TEST(Fit, BringsAShrunkenSphereBackToThePoints) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  const PointCloud cloud = sphere_cloud(5000);
  std::vector<double> error;
  std::string table = "steps  RMS distance to the sphere\n";
  for (int steps = 0; steps <= 4; ++steps) {
    error.push_back(rms_to_unit_sphere(fit(mesh, cloud, {.steps = steps, .refinements = 0}).mesh));
    table += std::to_string(steps) + "  " + std::to_string(error.back()) + "\n";
  }
  SCOPED_TRACE(table);
  EXPECT_GT(error[0], 0.01);
  for (int steps = 1; steps <= 2; ++steps) EXPECT_LT(error[steps], error[steps - 1]) << steps;
  EXPECT_LT(error[4], error[0] / 20);
  EXPECT_LT(rms_to_unit_sphere(fit(mesh, cloud).mesh), error[0] / 20);
}

TEST(Fit, HeldOutPointsTellHowCloseItCame) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  const Fit fitted = fit(mesh, sphere_cloud(16000, 0.002));
  EXPECT_NEAR(static_cast<double>(fitted.held_out_points), 1000, 100);  // three standard deviations of 16000 / 16
  EXPECT_NEAR(fitted.held_out_before, 0.03, 0.02);
  EXPECT_NEAR(fitted.held_out_after, 0.002 / 1.4826, 0.0005);  // the median of |noise|
  EXPECT_EQ(fit(mesh, sphere_cloud(1500, 0.002)).held_out_points, 0U);
}

TEST(Fit, StepsEndWhenPointsComeNoCloser) {
  const Fit fitted = fit(sphere_mesh(3, 0.97), sphere_cloud(1500, 0.01), {.steps = 100, .refinements = 0});
  EXPECT_GT(fitted.steps, 1);
  EXPECT_LT(fitted.steps, 20);
}

// A point of weight three is three points.
TEST(Fit, CountsAPointByItsWeight) {
  const CovMesh mesh = sphere_mesh(1, 0.97);
  PointCloud weighted = sphere_cloud(500, 0.01), repeated = weighted;
  weighted.weights.assign(500, 3);
  for (int copy = 0; copy < 2; ++copy)
    for (std::size_t i = 0; i < 500; ++i) repeated.positions.push_back(weighted.positions[i]);
  const FitOptions options{.refinements = 0};
  const Fit expected = fit(mesh, repeated, options);
  EXPECT_LT(max_distance(fit(mesh, weighted, options).mesh.vertices.means, expected.mesh.vertices.means), 1e-9);
  weighted.weights.clear();
  EXPECT_GT(max_distance(fit(mesh, weighted, options).mesh.vertices.means, expected.mesh.vertices.means), 1e-6);

  // Two shells: the surface goes to where the weight is.
  PointCloud shells = sphere_cloud(1000);
  for (std::size_t i = 0; i < 1000; ++i) shells.positions.push_back(1.1 * shells.positions[i]);
  const auto mean_radius = [&](double inner, double outer) {
    shells.weights.assign(1000, inner);
    shells.weights.resize(2000, outer);
    const CovMesh fitted = fit(mesh, shells, {.refinements = 0}).mesh;
    double sum = 0;
    for (const Vec3& mean : fitted.vertices.means) sum += mean.norm() / static_cast<double>(fitted.vertices.size());
    return sum;
  };
  EXPECT_LT(mean_radius(5, 1) + 0.01, mean_radius(1, 5));
}

TEST(Fit, LeavesAPlaneThroughItsPointsAlone) {
  const auto [mesh, rotation] = tilted_plane(6, true);
  test::Random random(8);
  PointCloud cloud;
  for (int i = 0; i < 2000; ++i)
    cloud.positions.push_back(rotation * Vec3(random.uniform(0, 6), random.uniform(0, 6), 0));
  EXPECT_LT(max_distance(fit(mesh, cloud).mesh.vertices.means, mesh.vertices.means), 1e-12);
}

// The points lie a constant above the plane. Anchors, one point each against those around
// a vertex, and three iterations hold the first step back, most at the corners, where the points of a quarter of a
// cell, about 140, count for the vertex, by the square of its weight: a few percent. Of 13 draws at most 3.7 % and 1.6
// %.
TEST(Fit, AlmostArrivesAtAParallelPlaneInOneStep) {
  const auto [mesh, rotation] = tilted_plane(6, true);
  test::Random random(8);
  PointCloud cloud;
  for (int i = 0; i < 20000; ++i)
    cloud.positions.push_back(rotation * Vec3(random.uniform(0, 6), random.uniform(0, 6), 0.125));
  const auto error = [&, &mesh = mesh, &rotation = rotation](int steps) {
    const CovMesh fitted = fit(mesh, cloud, {.steps = steps, .refinements = 0}).mesh;
    double largest = 0;
    for (std::size_t v = 0; v < fitted.vertices.size(); ++v) {
      const Vec3 move = rotation.transpose() * (fitted.vertices.means[v] - mesh.vertices.means[v]);
      largest = std::max(largest, (move - Vec3(0, 0, 0.125)).norm());
    }
    return largest;
  };
  EXPECT_LT(error(1), 0.05 * 0.125);
  EXPECT_LT(error(4), 0.02 * 0.125);
}

/// A fifth of the points, or more, uniform in a cube.
PointCloud with_outliers(PointCloud cloud, std::size_t outliers) {
  test::Random random(17, test::sampling);
  for (std::size_t i = 0; i < outliers; ++i) cloud.positions.push_back(random.vector(-1.5, 1.5));
  return cloud;
}

TEST(Fit, IgnoresGrossOutliers) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  const PointCloud clean = sphere_cloud(8000, 0.005);
  const double error = rms_to_unit_sphere(fit(mesh, clean).mesh);
  const double with_fifth = rms_to_unit_sphere(fit(mesh, with_outliers(clean, 2000)).mesh);
  EXPECT_LT(error, 0.002);
  EXPECT_LT(with_fifth, 1.5 * error) << error;
}

// When more than half of the points lie in the surface exactly, the robust width is zero: the rest must not count.
TEST(Fit, IgnoresOutliersOfAnExactPlane) {
  const CovMesh mesh = tilted_plane(6, false).mesh;
  test::Random random(8);
  PointCloud cloud;
  for (int i = 0; i < 2000; ++i)
    cloud.positions.emplace_back(random.uniform(0, 6), random.uniform(0, 6), i % 10 == 0 ? 2 : 0);
  EXPECT_LT(max_distance(fit(mesh, cloud).mesh.vertices.means, mesh.vertices.means), 1e-12);
}

TEST(Fit, LeavesVerticesFarFromThePointsWhereTheyAre) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  PointCloud half;
  for (const Vec3& p : sphere_cloud(4000).positions)
    if (p.z() > 0) half.positions.push_back(p);
  const CovMesh fitted = fit(mesh, half, {.refinements = 0}).mesh;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double z = mesh.vertices.means[v].z(), move = (fitted.vertices.means[v] - mesh.vertices.means[v]).norm();
    if (z > 0.3) {
      EXPECT_GT(move, 0.005) << z;
    }
    if (z < -0.6) {
      EXPECT_LT(move, 0.001) << z;
    }
  }
}

/// Two half planes that meet at a right angle in the y axis, with balls for Gaussians, which round it off.
CovMesh roof_mesh(Index cells) {
  CovMesh mesh = test::lattice(cells, [](double x, double y) {
    const double side = x < 0 ? -1 : 1, s = std::sqrt(0.5);
    return std::pair(Vec3(s * x, y, -s * std::abs(x)), Vec3(side * s, 0, s));
  });
  mesh.vertices.covariances.assign(mesh.vertices.size(), Sym3::identity(0.1));
  return mesh;
}
double distance_to_roof(const Vec3& p) {
  const double s = std::sqrt(0.5);
  // Each side within its half plane, or else the ridge.
  const auto side = [&](double sign) {
    const double along = s * (sign * p.x() - p.z()), above = s * (sign * p.x() + p.z());
    return along >= 0 ? std::abs(above) : std::hypot(p.x(), p.z());
  };
  return std::min(side(-1), side(1));
}

TEST(Fit, RefinesACrease) {
  const CovMesh mesh = roof_mesh(14);
  test::Random random(12, test::sampling);
  PointCloud cloud;
  const double s = std::sqrt(0.5);
  for (int i = 0; i < 20000; ++i) {
    const double x = random.uniform(-6, 6), y = random.uniform(-6, 6), noise = 0.01 * random.normal();
    cloud.positions.emplace_back(s * x + (x < 0 ? -s : s) * noise, y, -s * std::abs(x) + s * noise);
  }
  const auto error = [&](int refinements) {
    const CovMesh fitted = fit(mesh, cloud, {.refinements = refinements}).mesh;
    return test::rms_of_surface(
        fitted, [](const Vec3& p) { return std::abs(p.x()) < 1 && std::abs(p.y()) < 4 ? distance_to_roof(p) : 0; });
  };
  const double coarse = error(0), fine = error(2);
  EXPECT_LT(fine, 0.7 * coarse) << coarse << " " << fine;
}

// Points that fill space pull neighbours apart: no step may turn a face by more than a right angle.
TEST(Fit, StepsTurnNoFaceOver) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    test::Random random(seed, test::sampling);
    PointCloud cloud;
    for (int i = 0; i < 1500; ++i) cloud.positions.push_back(random.vector(-2, 2));
    cloud.weights.assign(1500, 1000);
    CovMesh mesh = sphere_mesh(4, random.uniform(0.5, 1.5));
    // No mean may leave its Gaussian either: balls leave room for folds.
    for (Sym3& c : mesh.vertices.covariances) c = Sym3::identity(c.trace() / 2);
    const Fit fitted = fit(mesh, cloud, {.steps = 1, .refinements = 0});
    EXPECT_GT(fitted.restrained_faces, 0U);  // the cloud is hostile enough
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      EXPECT_GE(test::area_vector(mesh.faces, f, mesh.vertices.means)
                    .dot(test::area_vector(mesh.faces, f, fitted.mesh.vertices.means)),
                0)
          << seed << " " << f;
    for (const Vec3& mean : fit(mesh, cloud).mesh.vertices.means) EXPECT_TRUE(mean.allFinite());
  }
}

/// Where the limit surface of a mesh in the plane z = 0 ends in the direction of x, along the middle third of that
/// side.
double end_in_x(const CovMesh& mesh, double low_y, double high_y) {
  const SurfaceSamples samples = LimitSurface(mesh.faces, mesh.vertices.size(), 2).evaluate(mesh.vertices);
  double end = -1e300;
  for (const Vec3& p : samples.positions)
    if (p.y() > low_y && p.y() < high_y) end = std::max(end, p.x());
  return end;
}

TEST(Fit, ExtendsTheRimToWhereThePointsEnd) {
  CovMesh mesh = tilted_plane(9, false).mesh;
  const Vec3 low = bounding_box(mesh.vertices.means).min(), high = bounding_box(mesh.vertices.means).max();
  const double edge = (high.x() - low.x()) / 9, step = edge / 8;
  mesh.vertices.spacing = step;
  const double third = (high.y() - low.y()) / 3;
  const auto end = [&](const CovMesh& m) { return end_in_x(m, low.y() + third, high.y() - third); };
  const double start = end(mesh);
  double error_before = start;
  for (const double beyond : {0.0, 0.2, 0.4}) {  // shares of an edge that the points reach past the rim
    PointCloud cloud;
    for (double x = low.x(); x <= start + beyond * edge; x += step)
      for (double y = low.y(); y <= high.y(); y += step) cloud.positions.push_back({x, y, 0});
    double last = 0;
    for (const Vec3& p : cloud.positions) last = std::max(last, p.x());
    const CovMesh fitted = fit(mesh, cloud, {.steps = 10, .refinements = 0}).mesh;
    EXPECT_NEAR(end(fitted), last, step) << beyond;
    EXPECT_GE(end(fitted), start - 1e-12) << beyond;
    for (const Vec3& mean : fitted.vertices.means) EXPECT_NEAR(mean.z(), 0, 1e-12);
    error_before = last - start;
  }
  EXPECT_GT(error_before, 2 * step);  // so the last distance was one to be made up

  // A stray beyond the rim is not a strip of points.
  PointCloud cloud;
  for (double x = low.x(); x <= start; x += step)
    for (double y = low.y(); y <= high.y(); y += step) cloud.positions.push_back({x, y, 0});
  const double without = end(fit(mesh, cloud).mesh);
  cloud.positions.push_back({start + 3.9 * step, 0.5 * (low.y() + high.y()), 0});
  EXPECT_LT(end(fit(mesh, cloud).mesh) - without, step);

  // Without a known spacing the rim stays.
  mesh.vertices.spacing = 0;
  EXPECT_NEAR(end(fit(mesh, cloud).mesh), start, 1e-9);
}

TEST(Fit, FollowsRigidMotions) {
  const CovMesh mesh = sphere_mesh(2, 0.97);
  const PointCloud cloud = sphere_cloud(2000, 0.02);
  const Mat3 rotation = test::Random(4).rotation();
  const Vec3 shift(3, -2, 1);
  CovMesh moved = mesh;
  PointCloud moved_cloud = cloud;
  for (Vec3& p : moved.vertices.means) p = rotation * p + shift;
  for (Sym3& c : moved.vertices.covariances) c = congruence(rotation, c);
  for (Vec3& p : moved_cloud.positions) p = rotation * p + shift;
  std::vector<Vec3> expected = fit(mesh, cloud).mesh.vertices.means;
  for (Vec3& p : expected) p = rotation * p + shift;
  EXPECT_LT(max_distance(fit(moved, moved_cloud).mesh.vertices.means, expected), 1e-9);
}

TEST(Fit, FollowsPowersOfTwoToTheBit) {
  const CovMesh mesh = sphere_mesh(2, 0.97);
  const PointCloud cloud = sphere_cloud(2000, 0.02);
  const CovMesh expected = fit(mesh, cloud).mesh;
  for (const double scale : {0x1p-20, 0.5, 0x1p30}) {
    CovMesh scaled = mesh;
    PointCloud scaled_cloud = cloud;
    for (Vec3& p : scaled.vertices.means) p *= scale;
    for (Sym3& c : scaled.vertices.covariances) c *= scale * scale;
    for (Vec3& p : scaled_cloud.positions) p *= scale;
    scaled = fit(scaled, scaled_cloud).mesh;
    for (Vec3& p : scaled.vertices.means) p /= scale;
    EXPECT_EQ(scaled.vertices.means, expected.vertices.means) << scale;
  }
}

TEST(Fit, DoesNotDependOnThreads) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  PointCloud cloud = sphere_cloud(20000, 0.01);
  for (Vec3& p : cloud.positions) p *= 1 + 0.05 * std::sin(25 * p.x());  // detail to refine for
  RunContext context;
  context.threads = 1;
  const Fit one = fit(mesh, cloud, {}, context);
  EXPECT_GT(one.added_vertices, 0U);
  for (const int threads : {2, 4}) {
    context.threads = threads;
    const Fit other = fit(mesh, cloud, {}, context);
    EXPECT_EQ(other.mesh.vertices.means, one.mesh.vertices.means) << threads;
    EXPECT_EQ(other.mesh.vertices.covariances, one.mesh.vertices.covariances) << threads;
    EXPECT_EQ(other.mesh.vertices.weights, one.mesh.vertices.weights) << threads;
    EXPECT_EQ(other.mesh.faces, one.mesh.faces) << threads;
    EXPECT_EQ(other.held_out_after, one.held_out_after) << threads;
  }
}

TEST(Fit, RefusesOptionsOutOfRange) {
  const auto message = [](const FitOptions& options) -> std::string {
    try {
      fit(sphere_mesh(0, 1), sphere_cloud(10), options);
    } catch (const OptionError& error) {
      return error.what();
    }
    return "";
  };
  using testing::AllOf, testing::HasSubstr;
  EXPECT_THAT(message({.steps = -1}), AllOf(HasSubstr("steps"), HasSubstr("-1")));
  EXPECT_THAT(message({.steps = 101}), AllOf(HasSubstr("steps"), HasSubstr("101")));
  EXPECT_THAT(message({.refinements = -1}), AllOf(HasSubstr("refinements"), HasSubstr("-1")));
  EXPECT_THAT(message({.refinements = 11}), AllOf(HasSubstr("refinements"), HasSubstr("11")));
  EXPECT_THAT(message({.level = 0}), AllOf(HasSubstr("level"), HasSubstr("0")));
  EXPECT_THAT(message({.level = 6}), AllOf(HasSubstr("level"), HasSubstr("6")));
  EXPECT_NO_THROW((FitOptions{.steps = 100, .refinements = 10, .level = 5}.check()));
  EXPECT_NO_THROW((FitOptions{.steps = 0, .refinements = 0, .level = 1}.check()));
}

TEST(Fit, StopsWhenCancelled) {
  std::atomic<bool> cancel = false;
  std::vector<double> shares;
  RunContext context;
  context.cancel = &cancel;
  context.on_progress = [&](std::string_view stage, double share) {
    EXPECT_EQ(stage, "fit");
    shares.push_back(share);
  };
  const CovMesh mesh = sphere_mesh(1, 0.97);
  const PointCloud cloud = sphere_cloud(500, 0.1);
  fit(mesh, cloud, {.refinements = 0}, context);
  EXPECT_THAT(shares, testing::ElementsAre(0.5, 1));
  shares.clear();
  context.on_progress = [&](std::string_view, double share) {
    shares.push_back(share);
    cancel = true;
  };
  EXPECT_THROW(fit(mesh, cloud, {.refinements = 0}, context), Cancelled);
  EXPECT_THAT(shares, testing::ElementsAre(0.5));
  shares.clear();
  EXPECT_THROW(fit(mesh, cloud, {}, context), Cancelled);  // before the first step
  EXPECT_THAT(shares, testing::IsEmpty());
}

}  // namespace
}  // namespace gpsrecon
