#include <gmock/gmock.h>
#include <gpsrecon/fit/fit.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gtest/gtest.h>

#include <atomic>
#include <numbers>

#include "gps/meshes.h"
#include "support/shapes.h"

namespace gpsrecon {
namespace {

using test::disc_covariance;
using test::max_distance;

/// Discs tangent to the unit sphere at the vertices of a triangulated sphere of radius `radius`.
CovMesh sphere_mesh(int level, double radius) {
  const Mesh sphere = test::sphere(level);
  const double edge = std::sqrt(4 * std::numbers::pi / static_cast<double>(sphere.positions.size()));
  std::vector<Sym3> covariances;
  for (const Vec3& n : sphere.positions) covariances.push_back(disc_covariance(n, 0.5 * edge, 0.1 * edge));
  CovMesh mesh = test::covariance_mesh(sphere, covariances);
  for (Vec3& mean : mesh.vertices.means) mean *= radius;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.vertices.weights[v] = 1 + 0.25 * static_cast<double>(v % 7);
  return mesh;
}

/// Points on the unit sphere with Gaussian noise.
PointCloud sphere_cloud(std::size_t n, double noise = 0) {
  test::SampledShape sphere = test::fibonacci_sphere(n);
  test::add_noise(sphere, noise, 5);
  return sphere.cloud();
}

/// A tilted plane: discs of different sizes over a grid, and the rotation that took it out of z = 0.
struct TiltedPlane {
  CovMesh mesh;
  Mat3 rotation;
};
TiltedPlane tilted_plane(Index cells, bool tilt) {
  test::RandomSequence random(3);
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

/// Root mean square of `distance` over the samples of the limit surface.
template <class Distance>
double rms_of_surface(const CovMesh& mesh, const Distance& distance) {
  const LimitSurface surface(mesh.faces, mesh.vertices.size(), 3);
  double sum = 0;
  const SurfaceSamples samples = surface.evaluate(mesh.vertices);
  for (const Vec3& p : samples.positions) sum += distance(p) * distance(p);
  return std::sqrt(sum / static_cast<double>(samples.positions.size()));
}
double rms_to_unit_sphere(const CovMesh& mesh) {
  return rms_of_surface(mesh, [](const Vec3& p) { return p.norm() - 1; });
}

void expect_same_but_means(const CovMesh& a, const CovMesh& b) {
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.vertices.covariances, b.vertices.covariances);
  EXPECT_EQ(a.vertices.weights, b.vertices.weights);
  EXPECT_EQ(a.vertices.sigma0, b.vertices.sigma0);
  EXPECT_EQ(a.vertices.spacing, b.vertices.spacing);
  EXPECT_EQ(a.vertices.frame, b.vertices.frame);
}

TEST(Fit, ReturnsTheMeshForZeroStepsAndForNoPoints) {
  const CovMesh mesh = sphere_mesh(2, 0.97);
  for (const CovMesh& same : {fit(mesh, sphere_cloud(500), {.steps = 0}), fit(mesh, PointCloud{})}) {
    expect_same_but_means(same, mesh);
    EXPECT_EQ(same.vertices.means, mesh.vertices.means);
  }
}

TEST(Fit, MovesNothingButTheMeans) {
  CovMesh mesh = sphere_mesh(2, 0.97);
  mesh.vertices.sigma0 = 0.01;
  mesh.vertices.spacing = 0.02;
  const CovMesh fitted = fit(mesh, sphere_cloud(2000));
  expect_same_but_means(fitted, mesh);
  EXPECT_GT(max_distance(fitted.vertices.means, mesh.vertices.means), 0.01);
}

TEST(Fit, BringsAShrunkenSphereBackToThePoints) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  const PointCloud cloud = sphere_cloud(5000);
  std::vector<double> error;
  std::string table = "steps  RMS distance to the sphere\n";
  for (int steps = 0; steps <= 6; ++steps) {
    error.push_back(rms_to_unit_sphere(fit(mesh, cloud, {.steps = steps})));
    table += std::to_string(steps) + "  " + std::to_string(error.back()) + "\n";
  }
  SCOPED_TRACE(table);
  EXPECT_GT(error[0], 0.01);
  for (int steps = 1; steps <= 3; ++steps) EXPECT_LT(error[steps], error[steps - 1]) << steps;
  EXPECT_LT(error[5], error[0] / 3);
}

TEST(Fit, StepsCompose) {
  const CovMesh mesh = sphere_mesh(2, 0.97);
  const PointCloud cloud = sphere_cloud(2000, 0.01);
  const CovMesh twice = fit(fit(mesh, cloud, {.steps = 2}), cloud, {.steps = 3});
  EXPECT_EQ(twice.vertices.means, fit(mesh, cloud, {.steps = 5}).vertices.means);
}

// Weights only enter as ratios, and a point of weight two is two points.
TEST(Fit, CountsAPointByItsWeight) {
  const CovMesh mesh = sphere_mesh(1, 0.97);
  PointCloud weighted = sphere_cloud(1000, 0.01), repeated = weighted;
  for (std::size_t i = 0; i < 1000; ++i) weighted.weights.push_back(3);
  for (std::size_t i = 0; i < 1000; ++i)
    for (int copy = 0; copy < 2; ++copy) repeated.positions.push_back(weighted.positions[i]);
  EXPECT_LT(max_distance(fit(mesh, weighted).vertices.means, fit(mesh, repeated).vertices.means), 1e-12);

  // Two shells: the surface goes to where the weight is.
  PointCloud shells = sphere_cloud(1000);
  for (std::size_t i = 0; i < 1000; ++i) shells.positions.push_back(1.1 * shells.positions[i]);
  const auto mean_radius = [&](double inner, double outer) {
    shells.weights.assign(1000, inner);
    shells.weights.resize(2000, outer);
    const CovMesh fitted = fit(mesh, shells);
    double sum = 0;
    for (const Vec3& mean : fitted.vertices.means) sum += mean.norm() / static_cast<double>(fitted.vertices.size());
    return sum;
  };
  EXPECT_LT(mean_radius(5, 1) + 0.01, mean_radius(1, 5));
}

TEST(Fit, LeavesAPlaneThroughItsPointsAlone) {
  const auto [mesh, rotation] = tilted_plane(6, true);
  test::RandomSequence random(8);
  PointCloud cloud;
  for (int i = 0; i < 2000; ++i)
    cloud.positions.push_back(rotation * Vec3(random.uniform(0, 6), random.uniform(0, 6), 0));
  EXPECT_LT(max_distance(fit(mesh, cloud).vertices.means, mesh.vertices.means), 1e-12);
}

// The points lie a constant above the plane: a mean offset of constants is that constant, so the first step arrives.
TEST(Fit, ArrivesAtAParallelPlaneInOneStep) {
  const auto [mesh, rotation] = tilted_plane(6, true);
  test::RandomSequence random(8);
  PointCloud cloud;
  for (int i = 0; i < 20000; ++i)
    cloud.positions.push_back(rotation * Vec3(random.uniform(0, 6), random.uniform(0, 6), 0.125));
  const CovMesh fitted = fit(mesh, cloud, {.steps = 1});
  for (std::size_t v = 0; v < fitted.vertices.size(); ++v) {
    const Vec3 move = rotation.transpose() * (fitted.vertices.means[v] - mesh.vertices.means[v]);
    EXPECT_LT((move - Vec3(0, 0, 0.125)).norm(), 1e-12) << v;
  }
}

TEST(Fit, IgnoresGrossOutliers) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  const PointCloud clean = sphere_cloud(5000, 0.005);
  PointCloud dirty = clean;
  test::Random random(17);
  for (int i = 0; i < 500; ++i) dirty.positions.push_back(random.uniform(1.4, 3) * random.direction());
  const CovMesh without = fit(mesh, clean), with = fit(mesh, dirty);
  double moved = 0, changed = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    moved += (without.vertices.means[v] - mesh.vertices.means[v]).squaredNorm();
    changed += (with.vertices.means[v] - without.vertices.means[v]).squaredNorm();
  }
  EXPECT_LT(std::sqrt(changed), 0.02 * std::sqrt(moved));
}

// When more than half of the points lie in the surface exactly, the robust width is zero: the rest must not count.
TEST(Fit, IgnoresOutliersOfAnExactPlane) {
  const CovMesh mesh = tilted_plane(6, false).mesh;
  test::RandomSequence random(8);
  PointCloud cloud;
  for (int i = 0; i < 2000; ++i)
    cloud.positions.emplace_back(random.uniform(0, 6), random.uniform(0, 6), i % 10 == 0 ? 2 : 0);
  EXPECT_LT(max_distance(fit(mesh, cloud).vertices.means, mesh.vertices.means), 1e-12);
}

TEST(Fit, LeavesVerticesWithoutPointsWhereTheyAre) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  PointCloud half;
  for (const Vec3& p : sphere_cloud(4000).positions)
    if (p.z() > 0) half.positions.push_back(p);
  const CovMesh fitted = fit(mesh, half, {.steps = 1});
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double z = mesh.vertices.means[v].z();
    if (std::abs(z) > 0.5) {
      EXPECT_EQ(fitted.vertices.means[v] == mesh.vertices.means[v], z < 0) << v;
    }
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
  Vec3 low = mesh.vertices.means.front(), high = low;
  for (const Vec3& mean : mesh.vertices.means) low = low.cwiseMin(mean), high = high.cwiseMax(mean);
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
    const CovMesh fitted = fit(mesh, cloud, {.steps = 10});
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
  const double without = end(fit(mesh, cloud));
  cloud.positions.push_back({start + 3.9 * step, 0.5 * (low.y() + high.y()), 0});
  EXPECT_LT(end(fit(mesh, cloud)) - without, step);

  // Without a known spacing the rim stays.
  mesh.vertices.spacing = 0;
  EXPECT_NEAR(end(fit(mesh, cloud)), start, 1e-9);
}

TEST(Fit, FollowsRigidMotions) {
  const CovMesh mesh = sphere_mesh(2, 0.97);
  const PointCloud cloud = sphere_cloud(2000, 0.02);
  const Mat3 rotation = test::RandomSequence(4).rotation();
  const Vec3 shift(3, -2, 1);
  CovMesh moved = mesh;
  PointCloud moved_cloud = cloud;
  for (Vec3& p : moved.vertices.means) p = rotation * p + shift;
  for (Sym3& c : moved.vertices.covariances) c = congruence(rotation, c);
  for (Vec3& p : moved_cloud.positions) p = rotation * p + shift;
  std::vector<Vec3> expected = fit(mesh, cloud).vertices.means;
  for (Vec3& p : expected) p = rotation * p + shift;
  EXPECT_LT(max_distance(fit(moved, moved_cloud).vertices.means, expected), 1e-9);
}

TEST(Fit, FollowsPowersOfTwoToTheBit) {
  const CovMesh mesh = sphere_mesh(2, 0.97);
  const PointCloud cloud = sphere_cloud(2000, 0.02);
  const CovMesh expected = fit(mesh, cloud);
  for (const double scale : {0x1p-20, 0.5, 0x1p30}) {
    CovMesh scaled = mesh;
    PointCloud scaled_cloud = cloud;
    for (Vec3& p : scaled.vertices.means) p *= scale;
    for (Sym3& c : scaled.vertices.covariances) c *= scale * scale;
    for (Vec3& p : scaled_cloud.positions) p *= scale;
    scaled = fit(scaled, scaled_cloud);
    for (Vec3& p : scaled.vertices.means) p /= scale;
    EXPECT_EQ(scaled.vertices.means, expected.vertices.means) << scale;
  }
}

TEST(Fit, DoesNotDependOnThreads) {
  const CovMesh mesh = sphere_mesh(3, 0.97);
  const PointCloud cloud = sphere_cloud(20000, 0.02);
  RunContext context;
  context.threads = 1;
  const CovMesh one = fit(mesh, cloud, {}, context);
  for (const int threads : {2, 4}) {
    context.threads = threads;
    EXPECT_EQ(fit(mesh, cloud, {}, context).vertices.means, one.vertices.means) << threads;
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
  EXPECT_THAT(message({.level = -1}), AllOf(HasSubstr("level"), HasSubstr("-1")));
  EXPECT_THAT(message({.level = 6}), AllOf(HasSubstr("level"), HasSubstr("6")));
  EXPECT_NO_THROW((FitOptions{.steps = 100, .level = 5}.check()));
  EXPECT_NO_THROW((FitOptions{.steps = 0, .level = 0}.check()));
}

TEST(Fit, StopsWhenCancelled) {
  std::atomic<bool> cancel = false;
  std::vector<double> shares;
  RunContext context;
  context.cancel = &cancel;
  context.on_progress = [&](std::string_view stage, double share) {
    EXPECT_EQ(stage, "fit");
    shares.push_back(share);
    cancel = shares.size() == 2;
  };
  EXPECT_THROW(fit(sphere_mesh(1, 0.97), sphere_cloud(500), {.steps = 4}, context), Cancelled);
  EXPECT_THAT(shares, testing::ElementsAre(0.25, 0.5));
}

}  // namespace
}  // namespace gpsrecon
