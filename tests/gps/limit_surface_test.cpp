#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/loop.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "support/covmeshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::max_distance;

CovMesh open_control(std::uint64_t seed) {
  return test::with_random_covariances(test::with_holes(test::irregular_sphere(seed), 11), seed + 1, 0.05, 0.5);
}

// The position is linear in the means, so that central differences are exact but for rounding.
TEST(LimitSurface, SpreadIsHowThePositionFollowsTheMeans) {
  const CovMesh mesh = open_control(3);
  const LimitSurface surface(mesh.faces, mesh.vertices.size(), 2);
  const SurfaceSamples samples = surface.evaluate(mesh.vertices);
  test::Random random(5);
  std::vector<Vec3> moves, levers;
  for (const Sym3& covariance : mesh.vertices.covariances) {
    moves.push_back(random.vector());
    levers.push_back(Cholesky3(covariance).solve(moves.back()));
  }
  const double h = 1e-3;
  const auto moved = [&](double step) {
    Mixture control = mesh.vertices;
    for (std::size_t i = 0; i < moves.size(); ++i) control.means[i] += step * moves[i];
    return surface.evaluate(control).positions;
  };
  const std::vector<Vec3> ahead = moved(h), behind = moved(-h), followed = surface.to_samples<Vec3>(levers);
  double largest = 0;
  for (std::size_t s = 0; s < surface.sample_count(); ++s) {
    const double difference = samples.normals[s].dot(ahead[s] - behind[s]) / (2 * h);
    EXPECT_NEAR(samples.spread[s].dot(followed[s]), difference, 1e-10) << s;
    largest = std::max(largest, std::abs(difference));
  }
  EXPECT_GT(largest, 0.3);
}

TEST(LimitSurface, SpreadAlongTheNormalIsTheVariance) {
  CovMesh mesh = open_control(4);
  mesh.vertices.sigma0 = 0.1;
  const LimitSurface surface(mesh.faces, mesh.vertices.size(), 1);
  for (const bool limit : {true, false}) {
    const SurfaceSamples samples = surface.evaluate(mesh.vertices, limit);
    for (std::size_t s = 0; s < surface.sample_count(); ++s)
      EXPECT_NEAR(samples.normals[s].dot(samples.spread[s]), samples.sigma[s] * samples.sigma[s] + 0.01, 1e-12) << s;
  }
}

/// A table as a dense matrix, column by column.
template <class Weight, class Part = std::identity>
Eigen::MatrixXd dense(const Stencils<Weight>& table, Part part = {}) {
  Eigen::MatrixXd matrix(table.rows(), table.columns);
  for (std::size_t c = 0; c < table.columns; ++c) {
    std::vector<double> unit(table.columns, 0.0), column(table.rows());
    unit[c] = 1;
    apply<double>(table, unit, column, {}, part);
    for (std::size_t r = 0; r < table.rows(); ++r) matrix(static_cast<long>(r), static_cast<long>(c)) = column[r];
  }
  return matrix;
}

TEST(LimitSurface, ToLevelAppliesTheTransposedTables) {
  const Mesh mesh = test::with_holes(test::irregular_sphere(6, 10), 11);
  const Connectivity coarse = triangle_connectivity(mesh.faces, mesh.positions.size());
  const Connectivity middle = refine_triangles(coarse), fine = refine_triangles(middle);
  const Eigen::MatrixXd first = dense(loop_stencils(coarse, LoopWeights::loop, CornerRule::smooth)),
                        second = dense(loop_stencils(middle, LoopWeights::loop, CornerRule::smooth)),
                        last = dense(limit_table(fine, LoopWeights::loop, CornerRule::smooth), &LimitWeight::position);
  const LimitSurface surface(mesh.faces, mesh.positions.size(), 2);
  test::Random random(2);
  std::vector<double> values(surface.sample_count());
  for (double& value : values) value = random.uniform(-1, 1);
  const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<long>(values.size()));
  const Eigen::VectorXd expected[] = {first.transpose() * (second.transpose() * (last.transpose() * y)),
                                      second.transpose() * (last.transpose() * y), last.transpose() * y};
  for (std::size_t level = 0; level <= 2; ++level) {
    const std::vector<double> found = surface.to_level<double>(values, level);
    ASSERT_EQ(found.size(), static_cast<std::size_t>(expected[level].size()));
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i], expected[level][static_cast<long>(i)], 1e-13) << level << " " << i;
  }
  EXPECT_EQ(surface.to_level<double>(values, 0), surface.to_control<double>(values));
}

TEST(LimitSurface, SamplesKnowTheControlVertexTheyGrewFrom) {
  const Mesh mesh = test::with_holes(test::irregular_sphere(7, 10), 11);
  const std::size_t n = mesh.positions.size();
  const LimitSurface surface(mesh.faces, n, 3);
  const std::vector<Index> control = surface.control_of_samples();
  ASSERT_EQ(control.size(), surface.sample_count());
  for (Index v = 0; v < n; ++v) EXPECT_EQ(control[v], v);
  Connectivity level = triangle_connectivity(mesh.faces, n);
  for (int l = 0; l < 3; ++l) {
    for (Index e = 0; e < level.edge_count(); ++e) {
      const Index h = level.edge_start[e];
      EXPECT_EQ(control[level.vertex_count + e], std::min(control[level.source(h)], control[level.target(h)]))
          << l << " " << e;
    }
    level = refine_triangles(level);
  }
  EXPECT_EQ(LimitSurface(mesh.faces, n, 0).control_of_samples().size(), n);
}

}  // namespace
}  // namespace gpsrecon
