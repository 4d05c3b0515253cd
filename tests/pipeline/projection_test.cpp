#include <gpsrecon/clop/particles.h>
#include <gpsrecon/clop/project.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/hem/hem.h>
#include <gpsrecon/pipeline/projection.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/random.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

/// A unit sphere with noise along the normal, points that are outliers by a tenth of it, and a scalar, the height.
PointCloud noisy_sphere(std::size_t n, double noise) {
  PointCloud cloud = test::fibonacci_sphere(n).cloud();
  test::Random random(31);
  for (std::size_t i = 0; i < n; ++i) cloud.positions[i] *= 1 + noise * random.normal();
  cloud.scalars = {{"height", {}, ScalarKind::quantity}};
  for (const Vec3& p : cloud.positions) cloud.scalars[0].values.push_back(p.z());
  return cloud;
}

double rms_offset(const PointCloud& cloud) {
  double sum = 0;
  for (const Vec3& p : cloud.positions) {
    const double d = cloud.frame.to_world(p).norm() - 1;
    sum += d * d / static_cast<double>(cloud.size());
  }
  return std::sqrt(sum);
}

PointCloud projected(const PreparedCloud& cloud, const ProjectionOptions& options, const RunContext& context = {}) {
  return project_points(cloud, options, context);
}

ProjectionOptions by(ProjectionMethod method) {
  ProjectionOptions options;
  options.method = method;
  return options;
}

TEST(Projection, EveryMethodTakesNoiseAway) {
  const PreparedCloud cloud = prepare(noisy_sphere(6000, 0.02));
  const double before = rms_offset(cloud.cloud);
  EXPECT_NEAR(before, 0.02, 0.002);
  for (const ProjectionMethod method : {ProjectionMethod::clop, ProjectionMethod::wlop, ProjectionMethod::lop})
    EXPECT_LT(rms_offset(projected(cloud, by(method))), 0.5 * before);
}

TEST(Projection, EveryMethodIsItsOperator) {
  const PreparedCloud cloud = prepare(noisy_sphere(3000, 0.02));
  const ProjectionOptions defaults;
  PointCloud places;
  places.positions = cloud.cloud.positions;
  places.frame = cloud.cloud.frame;
  const PointCloud particles = choose_particles(places, defaults.particles);
  ProjectOptions options = defaults.project;
  options.support_radius = automatic_support_radius(cloud.scale.spacing, cloud.scale.noise);
  for (const ProjectionMethod method : {ProjectionMethod::wlop, ProjectionMethod::lop}) {
    options.balance = method == ProjectionMethod::wlop;
    EXPECT_EQ(projected(cloud, by(method)).positions, project(particles, places, options).positions);
  }
  HemOptions hem = defaults.hem;
  hem.sigma0 = Length::scene(cloud.cloud.frame.scale() * projection_sigma0(cloud.scale, hem.initial));
  hem.spacing = Length::scene(cloud.cloud.frame.scale() * cloud.scale.spacing);
  options.balance = false;
  EXPECT_EQ(projected(cloud, by(ProjectionMethod::clop)).positions,
            project(particles, build_mixture(places, hem), options).positions);
}

TEST(Projection, AttributesComeFromTheNearestPoint) {
  const PreparedCloud cloud = prepare(noisy_sphere(3000, 0.01));
  const PointCloud particles = projected(cloud, {});
  ASSERT_EQ(particles.scalars.size(), 1U);
  ASSERT_EQ(particles.scalars[0].values.size(), particles.size());
  for (std::size_t i = 0; i < particles.size(); ++i)
    EXPECT_NEAR(particles.scalars[0].values[i], particles.frame.to_world(particles.positions[i]).z(), 0.15);
}

TEST(Projection, AsManyParticlesAsAskedFor) {
  const PreparedCloud cloud = prepare(noisy_sphere(2000, 0.01));
  ProjectionOptions options;
  options.particles.particles.count = 500;
  EXPECT_EQ(projected(cloud, options).size(), 500U);
  options.particles.particles.count = 0;
  options.particles.particles.ratio = 3;
  EXPECT_EQ(projected(cloud, options).size(), 6000U);
}

TEST(Projection, SameForAnyNumberOfThreads) {
  const PreparedCloud cloud = prepare(noisy_sphere(5000, 0.01));
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  for (const ProjectionMethod method : {ProjectionMethod::clop, ProjectionMethod::wlop})
    EXPECT_EQ(projected(cloud, by(method), one).positions, projected(cloud, by(method), four).positions);
}

TEST(Projection, TheChainUsesItAndStaysClosed) {
  const PointCloud cloud = noisy_sphere(6000, 0.02);
  ReconstructOptions options;
  const Reconstruction without = reconstruct(cloud, options);
  options.projection.emplace();
  const Reconstruction with = reconstruct(cloud, options);
  EXPECT_NE(with.covmesh.vertices.means, without.covmesh.vertices.means);
  EXPECT_EQ(with.report.mesh->topology.euler, 2);
  EXPECT_EQ(with.report.mesh->topology.boundary_loops, 0U);
  double sum = 0;
  for (const Vec3& p : with.mesh.positions) sum += std::pow(with.mesh.frame.to_world(p).norm() - 1, 2);
  EXPECT_LT(std::sqrt(sum / static_cast<double>(with.mesh.positions.size())), 0.006);
  // What is measured are the points themselves.
  EXPECT_NEAR(with.report.points_to_surface->distance.rms, without.report.points_to_surface->distance.rms, 0.002);
}

TEST(Projection, WhatContradictsIsRefused) {
  ReconstructOptions options;
  options.projection.emplace();
  options.max_error = Length::of_diagonal(0.01);
  EXPECT_THROW(options.check(), OptionError);
  ProjectionOptions bad;
  bad.support_radius = Length::of_diagonal(-1);
  EXPECT_THROW(bad.check(), OptionError);
}

}  // namespace
}  // namespace gpsrecon
