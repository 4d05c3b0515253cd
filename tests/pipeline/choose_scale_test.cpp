#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/pipeline/choose_scale.h>
#include <gtest/gtest.h>

#include "support/shapes.h"
#include "support/temporary_folder.h"

namespace gpsrecon {

using namespace internal;
namespace {

constexpr double noise = 0.01;

/// A wavy sphere, so that a wide kernel has something to smooth away.
PointCloud waves(std::size_t n = 12000, std::uint64_t seed = 1) {
  PointCloud cloud = test::noisy_sphere(n, noise, seed);
  for (Vec3& p : cloud.positions) p *= 1 + 0.06 * std::sin(6 * p.x()) * std::cos(5 * p.y());
  return cloud;
}

std::string bytes(const Reconstruction& result) {
  const test::TemporaryFolder folder;
  write_covmesh(result.covmesh, folder / "covmesh.ply");
  write_mesh(result.mesh, folder / "mesh.ply");
  return test::read_bytes(folder / "covmesh.ply") + test::read_bytes(folder / "mesh.ply");
}

std::string json(ErrorReport report) {
  report.run = {};
  return to_json(report);
}

RunContext with_seed(std::uint64_t seed) {
  RunContext context;
  context.seed = seed;
  return context;
}

TEST(Budget, IsNeverExceededAndNearlyUsedUp) {
  for (const std::uint64_t seed : {1u, 2u}) {
    const PointCloud cloud = waves(12000, seed);
    const std::size_t automatic = reconstruct(cloud, {}, with_seed(seed)).covmesh.vertices.size();
    for (const std::size_t budget : {automatic - 1, automatic * 2 / 3, automatic / 3, automatic / 7}) {
      ReconstructOptions options;
      options.budget = budget;
      const Reconstruction result = reconstruct(cloud, options, with_seed(seed));
      EXPECT_LE(result.covmesh.vertices.size(), budget);
      EXPECT_GE(result.covmesh.vertices.size(), budget * 3 / 4);
      EXPECT_EQ(result.report.mesh->topology.euler, 2) << budget;
      const ScaleSearchReport& search = *result.report.scale->search;
      EXPECT_EQ(search.by, "budget");
      EXPECT_EQ(search.wanted, static_cast<double>(budget));
      EXPECT_EQ(search.tried.front().detail, 1);
      EXPECT_EQ(search.tried[search.chosen].components, result.report.mixture->components);
      EXPECT_EQ(search.tried[search.chosen].sigma0, result.report.scale->sigma0);
    }
  }
}

TEST(Budget, ThatIsLargerThanNeededChangesNothing) {
  const PointCloud cloud = waves(4000);
  const Reconstruction automatic = reconstruct(cloud);
  for (const std::size_t more : {0u, 1u, 1000u}) {
    ReconstructOptions options;
    options.budget = automatic.covmesh.vertices.size() + more;
    EXPECT_EQ(bytes(reconstruct(cloud, options)), bytes(automatic)) << more;
  }
}

TEST(Budget, IsWhatDetailAndLimitOfTheFitGive) {
  const PointCloud cloud = waves(4000);
  ReconstructOptions by_budget, by_hand;
  by_budget.budget = 150;
  const Reconstruction result = reconstruct(cloud, by_budget);
  const ScaleSearchReport& search = *result.report.scale->search;
  by_hand.hem.detail = search.tried[search.chosen].detail;
  by_hand.fit.max_vertices = 150;
  EXPECT_LT(by_hand.hem.detail, 1);
  EXPECT_EQ(bytes(reconstruct(cloud, by_hand)), bytes(result));
}

TEST(Budget, ThatCannotBeKeptIsRefused) {
  ReconstructOptions options;
  options.budget = 3;
  EXPECT_THROW(options.check(), OptionError);
  // Fifty spheres far apart cannot be twenty Gaussians.
  PointCloud many;
  for (int s = 0; s < 50; ++s) {
    const int column = s % 10, row = s / 10;
    for (const Vec3& p : test::noisy_sphere(500, 0.01, 3 + s).positions)
      many.positions.push_back(p + Vec3(100 * column, 100 * row, 0));
  }
  EXPECT_EQ(reconstruct(many).report.covmesh->topology.components, 50u);
  options.budget = 20;
  EXPECT_THROW(reconstruct(many, options), OptionError);
  // One Gaussian per sphere would do, but there is no surface of it.
  options.budget = 70;
  EXPECT_THROW(reconstruct(many, options), OptionError);
  options.budget = 4;
  EXPECT_LE(reconstruct(waves(4000), options).covmesh.vertices.size(), 4u);
}

TEST(MaxError, GivesCoarserMeshesTheMoreItIs) {
  const PointCloud cloud = waves();
  std::size_t vertices = reconstruct(cloud).covmesh.vertices.size();
  const std::size_t automatic = vertices;
  for (const double limit : {0.0025, 0.005, 0.01, 0.02}) {
    ReconstructOptions options;
    options.max_error = Length::of_diagonal(limit);
    const Reconstruction result = reconstruct(cloud, options);
    const ScaleSearchReport& search = *result.report.scale->search;
    const ScaleTrial& chosen = search.tried[search.chosen];
    EXPECT_LE(*chosen.error, limit * result.report.diagonal);
    EXPECT_THAT(result.report.warnings, testing::IsEmpty());
    EXPECT_EQ(chosen.sigma0, result.report.scale->sigma0);
    for (const ScaleTrial& t : search.tried) {
      if (t.detail < chosen.detail && t.error) {
        EXPECT_GT(*t.error, limit * result.report.diagonal);
      }
    }
    EXPECT_LE(result.covmesh.vertices.size(), vertices);
    vertices = result.covmesh.vertices.size();
  }
  EXPECT_LT(vertices, automatic / 4);
}

TEST(MaxError, OutOfReachKeepsTheAutomaticKernelAndSaysSo) {
  const PointCloud cloud = waves(4000);
  ReconstructOptions options;
  options.max_error = Length::of_diagonal(1e-6);
  const Reconstruction result = reconstruct(cloud, options);
  EXPECT_EQ(bytes(result), bytes(reconstruct(cloud)));
  ASSERT_EQ(result.report.warnings.size(), 1u);
  EXPECT_THAT(result.report.warnings[0], testing::HasSubstr("cannot be promised"));
  EXPECT_EQ(result.report.scale->search->tried.size(), 1u);
}

TEST(CheckScale, ChangesNothingButTheReport) {
  const PointCloud cloud = waves(4000);
  ReconstructOptions options;
  options.check_scale = true;
  const Reconstruction result = reconstruct(cloud, options);
  EXPECT_EQ(bytes(result), bytes(reconstruct(cloud)));
  const ScaleCheckReport& check = *result.report.scale->check;
  EXPECT_NEAR(static_cast<double>(check.held_out_points), 800, 4 * std::sqrt(640.0));
  ASSERT_EQ(check.tried.size(), 5u);
  double best = -1e300;
  for (const KernelLikelihood& t : check.tried) {
    if (t.mean_log_likelihood > best) best = t.mean_log_likelihood;
    EXPECT_NEAR(t.sigma0, t.factor * check.tried[2].sigma0, 1e-12);
  }
  for (const KernelLikelihood& t : check.tried) {
    if (t.factor == check.best) {
      EXPECT_EQ(t.mean_log_likelihood, best);
    }
  }
  // Many Gaussians for a wide kernel would be a mistake.
  EXPECT_GT(check.tried.front().components, check.tried.back().components);
}

TEST(CheckScale, DoesNotDependOnUnits) {
  ReconstructOptions options;
  options.check_scale = true;
  const auto check = [&](double factor) {
    return *reconstruct(test::scaled(waves(2000), factor), options).report.scale->check;
  };
  const ScaleCheckReport a = check(1), b = check(1000);
  for (std::size_t i = 0; i < a.tried.size(); ++i)
    EXPECT_NEAR(a.tried[i].mean_log_likelihood, b.tried[i].mean_log_likelihood, 1e-6);
}

TEST(ChooseScale, DoesNotDependOnThreads) {
  const PointCloud cloud = waves(4000);
  for (const bool by_budget : {true, false}) {
    ReconstructOptions options;
    options.check_scale = true;
    if (by_budget)
      options.budget = 150;
    else
      options.max_error = Length::of_diagonal(0.01);
    RunContext one, three;
    one.threads = 1;
    three.threads = 3;
    const Reconstruction a = reconstruct(cloud, options, one), b = reconstruct(cloud, options, three);
    EXPECT_EQ(bytes(a), bytes(b));
    EXPECT_EQ(json(a.report), json(b.report));
  }
}

TEST(ChooseScale, TakesTinyClouds) {
  const PointCloud cloud = test::noisy_sphere(200, 0.01);
  ReconstructOptions options;
  options.check_scale = true;
  options.max_error = Length::of_diagonal(0.01);
  const Reconstruction result = reconstruct(cloud, options);
  EXPECT_EQ(bytes(result), bytes(reconstruct(cloud)));
  EXPECT_EQ(result.report.warnings.size(), 2u);
}

TEST(ChooseScale, RefusesContradictions) {
  const auto refused = [](auto change) {
    ReconstructOptions options;
    change(options);
    EXPECT_THROW(options.check(), OptionError);
  };
  refused([](ReconstructOptions& o) { o.budget = 10, o.max_error = Length::of_diagonal(0.1); });
  refused([](ReconstructOptions& o) { o.budget = 10, o.hem.detail = 2; });
  refused([](ReconstructOptions& o) { o.budget = 10, o.hem.sigma0 = Length::of_diagonal(0.1); });
  refused([](ReconstructOptions& o) { o.budget = 10, o.hem.target_components = 5; });
  refused([](ReconstructOptions& o) { o.budget = 10, o.fit.max_vertices = 5; });
  refused([](ReconstructOptions& o) { o.max_error = Length::of_diagonal(0.1), o.hem.detail = 2; });
  refused([](ReconstructOptions& o) { o.max_error = Length::of_diagonal(0.1), o.fit.max_vertices = 5; });
  refused([](ReconstructOptions& o) { o.max_error = Length::of_diagonal(-1); });
  ReconstructOptions options;
  options.budget = 100;
  EXPECT_THROW(reconstruct(Mixture{}, options), OptionError);
  EXPECT_THROW(reconstruct(CovMesh{}, options), OptionError);
}

}  // namespace
}  // namespace gpsrecon
