// The 3x3 algebra against Eigen and against its definitions.

#include <gpsrecon/core/sym3.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "support/random.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

double distance(const Sym3& a, const Mat3& b) {
  return (a.matrix() - b).norm();
}

TEST(Sym3, ArithmeticIsThatOfMatrices) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Mat3 m = random.matrix(), n = random.matrix();
    const Sym3 a = Sym3::from_matrix(m), b = Sym3::from_matrix(n);
    const Vec3 v = random.vector();
    const Mat3 am = a.matrix(), bm = b.matrix();
    EXPECT_LT(distance(a, 0.5 * (m + m.transpose())), 1e-15);
    EXPECT_LT(distance(a + 2.5 * b, am + 2.5 * bm), 1e-15);
    EXPECT_LT(distance(a - b, am - bm), 1e-15);
    EXPECT_LT((a * v - am * v).norm(), 1e-15);
    EXPECT_NEAR(a.trace(), am.trace(), 1e-15);
    EXPECT_NEAR(a.determinant(), am.determinant(), 1e-15);
    EXPECT_NEAR(a.quadratic_form(v), v.dot(am * v), 1e-15);
    EXPECT_NEAR(trace_of_product(a, b), (am * bm).trace(), 1e-14);
    EXPECT_LT(distance(congruence(n, a), n * am * n.transpose()), 1e-14);
    EXPECT_LT(distance(Sym3::outer(v), v * v.transpose()), 1e-16);
  }
  EXPECT_LT(distance(Sym3::identity(3), 3 * Mat3::Identity()), 1e-300);
  EXPECT_LT(distance(Sym3::diagonal(1, 2, 3), Vec3(1, 2, 3).asDiagonal().toDenseMatrix()), 1e-300);
}

TEST(Sym3, FinitenessSeesEveryEntry) {
  EXPECT_TRUE(Sym3::identity().all_finite());
  for (double Sym3::*entry : {&Sym3::xx, &Sym3::xy, &Sym3::xz, &Sym3::yy, &Sym3::yz, &Sym3::zz})
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      Sym3 a = Sym3::identity();
      a.*entry = bad;
      EXPECT_FALSE(a.all_finite());
    }
}

TEST(Cholesky3, FactorsSolvesAndInverts) {
  Random random(2);
  for (const double condition : {1.0, 1e3, 1e6, 1e9})
    for (int trial = 0; trial < 50; ++trial) {
      const Sym3 a = random.covariance(1 / condition, 1);
      const Cholesky3 factor(a);
      ASSERT_TRUE(factor.valid());
      Mat3 lower;
      lower << factor.l00, 0, 0, factor.l10, factor.l11, 0, factor.l20, factor.l21, factor.l22;
      EXPECT_LT(distance(a, lower * lower.transpose()), 1e-15);
      const Vec3 v = random.vector();
      EXPECT_LT((lower * factor.solve_lower(v) - v).norm(), 1e-14 * std::sqrt(condition));
      // Backward stable: the residual is small compared with |A| |x|.
      const Vec3 x = factor.solve(v);
      EXPECT_LT((a * x - v).norm(), 1e-14 * x.norm());
      const Mat3 inverse = factor.inverse().matrix();
      EXPECT_LT((inverse * a.matrix() - Mat3::Identity()).norm(), 1e-14 * condition);
      EXPECT_LT((inverse - a.matrix().inverse()).norm(), 1e-13 * condition * inverse.norm());
      const double expected = std::log(a.matrix().eval().ldlt().vectorD().prod());
      EXPECT_NEAR(factor.log_determinant(), expected, 1e-14 * condition);
    }
}

TEST(Cholesky3, TellsWhatIsNotPositiveDefinite) {
  EXPECT_TRUE(Cholesky3(Sym3::diagonal(1, 2, 3)).valid());
  for (const Sym3& a : {Sym3::diagonal(1, 1, -1), Sym3::diagonal(-1, 1, 1), Sym3::diagonal(1, 0, 1), Sym3{},
                        Sym3{1, 2, 0, 1, 0, 1}, Sym3::identity(std::numeric_limits<double>::quiet_NaN())})
    EXPECT_FALSE(Cholesky3(a).valid());
}

TEST(Inverse, WorksForIndefiniteMatrices) {
  Random random(3);
  for (int trial = 0; trial < 100; ++trial) {
    const Sym3 a = Sym3::from_matrix(random.matrix());
    if (std::abs(a.determinant()) < 1e-3) continue;
    EXPECT_LT((inverse(a).matrix() * a.matrix() - Mat3::Identity()).norm(), 1e-11);
  }
}

TEST(EigenDecomposition, RebuildsTheMatrix) {
  Random random(4);
  for (const double condition : {1.0, 1e6, 1e12})
    for (int trial = 0; trial < 50; ++trial) {
      const Mat3 rotation = random.rotation();
      const Vec3 values(1 / condition, random.uniform(1 / condition, 1), 1);
      const Sym3 a = Sym3::from_matrix(rotation * values.asDiagonal() * rotation.transpose());
      const Eigen3 e = eigen_decomposition(a);
      EXPECT_LT((e.values - values).norm(), 1e-14);
      EXPECT_LT((e.vectors.transpose() * e.vectors - Mat3::Identity()).norm(), 1e-14);
      EXPECT_LT(distance(a, e.vectors * e.values.asDiagonal() * e.vectors.transpose()), 1e-14);
    }
}

TEST(LargestEigenvalue, AgreesWithTheDecomposition) {
  Random random(5);
  for (int trial = 0; trial < 500; ++trial) {
    const Sym3 a = trial % 2 == 0 ? random.covariance(1e-6, 1) : Sym3::from_matrix(random.matrix());
    const double expected = eigen_decomposition(a).values[2];
    EXPECT_NEAR(largest_eigenvalue(a), expected, 1e-7 * std::max(std::abs(expected), a.matrix().norm()));
  }
  for (const double s : {0.0, 1.0, -2.0, 1e-200, 1e100}) EXPECT_EQ(largest_eigenvalue(Sym3::identity(s)), s);
  // Discs, where the largest eigenvalue is double.
  for (int trial = 0; trial < 100; ++trial) {
    const Sym3 disc = congruence(random.rotation(), Sym3::diagonal(1, 1, 1e-4));
    EXPECT_NEAR(largest_eigenvalue(disc), 1, 1e-7);
  }
}

TEST(FloorEigenvalues, RaisesOnlyWhatIsTooSmall) {
  Random random(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Mat3 rotation = random.rotation();
    const Vec3 values(1e-9, random.uniform(1e-9, 1e-3), 2);
    const Sym3 a = Sym3::from_matrix(rotation * values.asDiagonal() * rotation.transpose());
    const Vec3 raised = values.cwiseMax(2e-5);
    const Sym3 floored = floor_eigenvalues(a, 1e-5);
    EXPECT_LT(distance(floored, rotation * raised.asDiagonal() * rotation.transpose()), 1e-14);
    EXPECT_GE(eigen_decomposition(floored).values[0], 2e-5 * (1 - 1e-9));
    const Sym3 fine = random.covariance(1e-3, 1);
    EXPECT_EQ(floor_eigenvalues(fine, 1e-4), fine);
  }
  // Rank one and rank zero.
  const Sym3 rod = floor_eigenvalues(Sym3::outer(Vec3(0, 0, 3)), 0.01);
  EXPECT_LT(distance(rod, Vec3(0.09, 0.09, 9).asDiagonal().toDenseMatrix()), 1e-14);
  EXPECT_EQ(floor_eigenvalues(Sym3{}, 0.01), Sym3{});
}

}  // namespace
}  // namespace gpsrecon::test
