// Colours, quantities and labels on the refined surface.

#include <gmock/gmock.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/subdivide.h>
#include <gtest/gtest.h>

#include <limits>

#include "support/covmeshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

using testing::IsNan;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A flat piece with Gaussians that are round within the plane, of sizes that differ tenfold.
CovMesh flat_covmesh() {
  Mesh flat = grid(8, 7);
  Random random(3);
  std::vector<Sym3> covariances;
  for (Vec3& p : flat.positions) {
    p += Vec3(0.3 * random.uniform(-1, 1), 0.3 * random.uniform(-1, 1), 0);
    const double variance = random.uniform(0.05, 0.5);
    covariances.push_back(variance * Sym3::identity() +
                          (random.uniform(0.001, 1) - 1) * variance * Sym3::outer(Vec3::UnitZ()));
  }
  return covariance_mesh(flat, covariances);
}

TEST(SubdivideAttributes, ConstantsStayConstant) {
  CovMesh mesh = with_random_covariances(with_holes(irregular_sphere(21), 7), 5);
  const std::size_t n = mesh.vertices.size();
  mesh.vertices.colors.assign(n, {0, 129, 255});
  mesh.vertices.scalars = {{"height", std::vector<double>(n, 0.1)}};
  const Mesh surface = subdivide(mesh, {.levels = 2});
  ASSERT_EQ(surface.colors.size(), surface.positions.size());
  for (const Color& color : surface.colors) ASSERT_EQ(color, (Color{0, 129, 255}));
  for (const double value : surface.scalars.at(0).values) ASSERT_NEAR(value, 0.1, 1e-15);
}

TEST(SubdivideAttributes, AffineFunctionsOfAPlaneAreReproduced) {
  CovMesh mesh = flat_covmesh();
  const auto height = [](const Vec3& p) { return 3 + 2 * p.x() - 5 * p.y(); };
  const auto red = [](const Vec3& p) { return 20 * p.x() + 40; };
  mesh.vertices.scalars = {{"height", {}}};
  for (const Vec3& p : mesh.vertices.means) {
    mesh.vertices.scalars[0].values.push_back(height(p));
    mesh.vertices.colors.push_back({static_cast<std::uint8_t>(std::lround(red(p))), 0, 0});
  }
  const Mesh surface = subdivide(mesh, {.levels = 2});
  for (std::size_t u = 0; u < surface.positions.size(); ++u) {
    ASSERT_NEAR(surface.scalars[0].values[u], height(surface.positions[u]), 1e-11);
    // Rounded at the control vertices and here.
    ASSERT_LE(std::abs(surface.colors[u][0] - red(surface.positions[u])), 1.0);
  }
}

TEST(SubdivideAttributes, NothingLeavesItsRange) {
  CovMesh mesh = with_random_covariances(with_holes(irregular_sphere(8), 5), 9, 1e-4, 1);
  Random random(2);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.vertices.colors.push_back({static_cast<std::uint8_t>(100 + random.below(50)), 0, 255});
  for (const LoopWeights weights : {LoopWeights::loop, LoopWeights::warren})
    for (const Color& color : subdivide(with_rules(mesh, {.weights = weights}), {.levels = 3}).colors) {
      ASSERT_GE(color[0], 100);
      ASSERT_LE(color[0], 149);
      ASSERT_EQ(color[1], 0);
      ASSERT_EQ(color[2], 255);
    }
}

TEST(SubdivideAttributes, MissingNumbersDoNotCount) {
  CovMesh mesh = flat_covmesh();
  const std::size_t n = mesh.vertices.size();
  std::vector<double> holed(n, 7), empty(n, nan);
  // No two of them are neighbours, so that every sample has others.
  for (std::size_t v = 3; v < n; v += 7) holed[v] = v % 2 == 0 ? nan : 1e39;
  mesh.vertices.scalars = {{"holed", holed}, {"empty", empty}, {"labels", empty, ScalarKind::label}};
  const Mesh surface = subdivide(mesh, {.levels = 2});
  for (const double value : surface.scalars[0].values) ASSERT_NEAR(value, 7, 1e-14);
  EXPECT_THAT(surface.scalars[1].values, testing::Each(IsNan()));
  EXPECT_THAT(surface.scalars[2].values, testing::Each(IsNan()));
}

// With equal covariances weights are those of the limit positions alone, which carry a one for each label.
TEST(SubdivideAttributes, LabelsAreThoseOfTheLargestWeight) {
  CovMesh mesh = with_equal_covariances(with_holes(irregular_sphere(4), 6), Sym3::identity(0.1));
  const std::size_t n = mesh.vertices.size();
  const std::vector<double> names{-3, 0, 8, 1000000007};
  Random random(6);
  ScalarColumn labels{"segment", {}, ScalarKind::label};
  for (std::size_t v = 0; v < n; ++v) labels.values.push_back(names[random.below(names.size())]);
  mesh.vertices.scalars = {labels};
  for (const int levels : {0, 1, 3}) {
    const Mesh surface = subdivide(mesh, {.levels = levels});
    const LimitSurface limit(mesh.faces, n, levels);
    std::vector<std::vector<double>> share;
    for (const double name : names) {
      std::vector<double> one(n);
      for (std::size_t v = 0; v < n; ++v) one[v] = labels.values[v] == name ? 1 : 0;
      share.push_back(limit.to_samples<double>(one));
    }
    ASSERT_EQ(surface.scalars.at(0).kind, ScalarKind::label);
    for (std::size_t u = 0; u < surface.positions.size(); ++u) {
      const auto found = std::find(names.begin(), names.end(), surface.scalars[0].values[u]);
      ASSERT_NE(found, names.end());
      for (std::size_t k = 0; k < names.size(); ++k)
        ASSERT_GE(share[static_cast<std::size_t>(found - names.begin())][u], share[k][u] - 1e-12);
    }
  }
}

TEST(SubdivideAttributes, NoneForNone) {
  const Mesh surface = subdivide(flat_covmesh());
  EXPECT_TRUE(surface.colors.empty());
  EXPECT_TRUE(surface.scalars.empty());
}

TEST(SubdivideAttributes, AreTheSameForAnyNumberOfThreads) {
  CovMesh mesh = with_random_covariances(irregular_sphere(11), 12);
  Random random(7);
  mesh.vertices.scalars = {{"a", {}}, {"b", {}, ScalarKind::label}};
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    mesh.vertices.scalars[0].values.push_back(random.uniform());
    mesh.vertices.scalars[1].values.push_back(static_cast<double>(random.below(5)));
  }
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  const Mesh a = subdivide(mesh, {.levels = 3}, one), b = subdivide(mesh, {.levels = 3}, four);
  EXPECT_EQ(a.scalars[0].values, b.scalars[0].values);
  EXPECT_EQ(a.scalars[1].values, b.scalars[1].values);
}

TEST(Infer, KeepsAttributes) {
  Mesh mesh = octahedron();
  mesh.colors.assign(6, {1, 2, 3});
  mesh.scalars = {{"label", {1, 2, 3, 4, 5, 6}, ScalarKind::label}};
  const CovMesh inferred = infer_covariances(mesh).mesh;
  EXPECT_EQ(inferred.vertices.colors, mesh.colors);
  EXPECT_EQ(inferred.vertices.scalars.at(0).values, mesh.scalars[0].values);
}

}  // namespace
}  // namespace gpsrecon::test
