#include <gpsrecon/fit/least_squares.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "support/covmeshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

VectorXd vector(const std::vector<double>& values) {
  return Eigen::Map<const VectorXd>(values.data(), static_cast<long>(values.size()));
}

/// A small irregular mesh with boundaries and Gaussians of all shapes, noisy points around it, and the normal equations
/// N x = b of the least squares problem, dense.
struct Problem {
  CovMesh mesh;
  LimitSurface surface;
  ControlEdges edges;
  SurfaceSamples samples;
  Residuals residuals;
  std::vector<double> moved;
  MatrixXd normal_matrix, preconditioner;  // the latter diagonal
  VectorXd right_side;

  Problem(std::size_t points, std::uint64_t seed, bool moved_before)
      : mesh(test::with_random_covariances(test::with_holes(test::irregular_sphere(seed, 12), 9), seed + 1, 0.02, 0.1)),
        surface(mesh.faces, mesh.vertices.size(), 2),
        edges(control_edges(triangle_connectivity(mesh.faces, mesh.vertices.size()))),
        samples(surface.evaluate(mesh.vertices)) {
    test::SampledShape sphere = test::random_sphere(points, seed + 2);
    test::add_noise(sphere, 0.03, seed + 3);
    const PointCloud cloud = sphere.cloud();
    const Assignment assignment = assign_points(samples, cloud, {});
    residuals = robust_residuals(surface, assignment, cloud, std::vector<char>(points, 0), median_offset(assignment));
    test::Random random(seed + 4);
    moved.assign(mesh.vertices.size(), 0.0);
    if (moved_before)
      for (double& move : moved) move = random.uniform(-0.05, 0.05);
    build();
  }

  void build() {
    const auto n = static_cast<long>(surface.control_count()), m = static_cast<long>(surface.sample_count());
    // Positions are linear in the means: central differences are exact but for rounding.
    MatrixXd a(m, n);
    const double h = 1e-2;
    for (long i = 0; i < n; ++i) {
      const auto positions = [&](double step) {
        Mixture control = mesh.vertices;
        control.means[i] += step * samples.normals[i];
        return surface.evaluate(control).positions;
      };
      const std::vector<Vec3> ahead = positions(h), behind = positions(-h);
      for (long s = 0; s < m; ++s) a(s, i) = samples.normals[s].dot(ahead[s] - behind[s]) / (2 * h);
    }
    MatrixXd weights(m, n);  // W_i of the limit positions
    for (long i = 0; i < n; ++i) {
      std::vector<double> unit(n, 0.0);
      unit[i] = 1;
      weights.col(i) = vector(surface.to_samples<double>(unit));
    }
    const VectorXd w = vector(residuals.weight), around = weights.transpose() * w;
    const VectorXd variance =
        (weights.transpose() * vector(residuals.square)).array() / around.array().square();  // NaN without points
    const auto hold = [](double move, double var) {
      return move == 0 || !std::isfinite(var) ? 1 : var / (var + 0.2 * move * move);
    };
    MatrixXd priors = MatrixXd::Zero(n, n);
    for (long i = 0; i < n; ++i) priors(i, i) += hold(moved[i], variance[i]);
    for (const auto& [p, q] : edges) {
      const double coupling = 3.0 / 6 * hold(moved[p] - moved[q], variance[p] + variance[q]);
      priors(p, p) += coupling;
      priors(q, q) += coupling;
      priors(p, q) -= coupling;
      priors(q, p) -= coupling;
    }
    normal_matrix = a.transpose() * w.asDiagonal() * a + priors;
    right_side = a.transpose() * vector(residuals.moment) - priors * vector(moved);
    const VectorXd row_sum = (a.transpose() * w).cwiseMax(0) + priors.diagonal();
    preconditioner = row_sum.cwiseInverse().asDiagonal();
  }

  VectorXd solved() const { return vector(solve_moves(surface, mesh.vertices, edges, samples, residuals, moved, {})); }
  /// ½ xᵀNx - bᵀx, what conjugate gradients minimise.
  double energy(const VectorXd& x) const { return 0.5 * x.dot(normal_matrix * x) - right_side.dot(x); }
  /// Its minimum over the Krylov space of so many dimensions.
  VectorXd best_in_krylov_space(long dimensions) const {
    MatrixXd basis(right_side.size(), dimensions);
    VectorXd next = preconditioner * right_side;
    for (long k = 0; k < dimensions; ++k) {
      for (int pass = 0; pass < 2; ++pass)
        for (long j = 0; j < k; ++j) next -= basis.col(j).dot(next) * basis.col(j);
      basis.col(k) = next.normalized();
      next = preconditioner * (normal_matrix * basis.col(k));
    }
    const MatrixXd small = basis.transpose() * normal_matrix * basis;
    return basis * small.ldlt().solve(basis.transpose() * right_side);
  }
};

// Three iterations of preconditioned conjugate gradients end in the best point of the Krylov space of three dimensions:
// the matrix, the right side and the preconditioner must all be those of the dense equations for that.
TEST(LeastSquares, FindsTheBestMovesOfThreeIterations) {
  for (const std::size_t points : {200, 5000})
    for (const bool moved_before : {false, true}) {
      SCOPED_TRACE(testing::Message() << points << " points, " << (moved_before ? "moved before" : "first step"));
      const Problem problem(points, 20, moved_before);
      const VectorXd found = problem.solved(), expected = problem.best_in_krylov_space(3);
      EXPECT_GT(expected.norm(), 0.1);
      EXPECT_LT((found - expected).norm(), 1e-9 * expected.norm());
      // Against the solution of the equations: most of what can be gained, and no more.
      const VectorXd exact = problem.normal_matrix.ldlt().solve(problem.right_side);
      const double share = problem.energy(found) / problem.energy(exact);
      EXPECT_GT(share, 0.8);
      EXPECT_LE(share, 1 + 1e-12);
    }
}

// The residuals of a rigid shift of the control vertices along their normals are a solution that is known.
TEST(LeastSquares, ConstantOffsetsAreAlmostOneIteration) {
  const CovMesh mesh = test::flat_lattice(8);
  const LimitSurface surface(mesh.faces, mesh.vertices.size(), 2);
  const std::vector<double> ones(surface.sample_count(), 1.0), offsets(surface.sample_count(), 0.25),
      squares(surface.sample_count(), 0.0625), zero(mesh.vertices.size(), 0.0);
  for (const double weight : {1.0, 100.0}) {
    Residuals residuals{ones, offsets, squares};
    for (auto* sums : {&residuals.weight, &residuals.moment, &residuals.square})
      for (double& value : *sums) value *= weight;
    const std::vector<double> moves =
        solve_moves(surface, mesh.vertices, control_edges(triangle_connectivity(mesh.faces, mesh.vertices.size())),
                    surface.evaluate(mesh.vertices), residuals, zero, {});
    // The anchor of a vertex is one point against those around it, at the fewest those of a corner.
    const std::vector<double> around = surface.to_control<double>(residuals.weight);
    const double fewest = *std::min_element(around.begin(), around.end());
    for (const double move : moves) EXPECT_NEAR(move, 0.25, 0.25 * 2 / fewest) << weight;
  }
}

TEST(LeastSquares, NoPointsNoMoves) {
  Problem problem(200, 20, false);
  for (auto* sums : {&problem.residuals.weight, &problem.residuals.moment, &problem.residuals.square})
    std::fill(sums->begin(), sums->end(), 0.0);
  EXPECT_EQ(problem.solved().norm(), 0);
}

TEST(LeastSquares, ControlEdgesAreThoseOfTheFaces) {
  const Mesh mesh = test::with_holes(test::irregular_sphere(3), 9);
  const Connectivity topology = triangle_connectivity(mesh.faces, mesh.positions.size());
  std::vector<std::array<Index, 2>> found = control_edges(topology), expected;
  EXPECT_EQ(found.size(), topology.edge_count());
  for (auto& [a, b] : found)
    if (a > b) std::swap(a, b);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(mesh.faces[f][k], mesh.faces[f][(k + 1) % 3]);
      expected.push_back({a, b});
    }
  std::sort(found.begin(), found.end());
  std::sort(expected.begin(), expected.end());
  expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace gpsrecon
