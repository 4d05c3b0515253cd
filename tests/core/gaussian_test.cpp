// Densities, divergences and products of Gaussians against numerical quadrature and their identities.

#include <gpsrecon/core/gaussian.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "support/random.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

FactoredGaussian random_gaussian(Random& random, double low = 0.05, double high = 1) {
  const Vec3 mean = random.vector();
  return FactoredGaussian({mean, random.covariance(low, high)});
}

/// ∫ f over a cube around the origin, by the trapezoidal rule: exact to rounding for smooth functions that vanish at
/// the border.
template <class Function>
double integrate(const Function& f, double half_width = 7, int steps = 80) {
  const double h = 2 * half_width / steps;
  double sum = 0;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= steps; ++j)
      for (int k = 0; k <= steps; ++k) sum += f(Vec3(i * h, j * h, k * h) - Vec3::Constant(half_width));
  return sum * h * h * h;
}

TEST(LogDensity, IsADensityWithTheGivenMoments) {
  Random random(1);
  const FactoredGaussian g = random_gaussian(random, 0.2, 1);
  EXPECT_NEAR(integrate([&](const Vec3& x) { return std::exp(log_density(g, x)); }), 1, 1e-7);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(integrate([&](const Vec3& x) { return x[axis] * std::exp(log_density(g, x)); }), g.mean[axis], 1e-6);
  EXPECT_NEAR(integrate([&](const Vec3& x) { return (x - g.mean).squaredNorm() * std::exp(log_density(g, x)); }),
              g.covariance.trace(), 1e-5);
}

TEST(LogDensity, IsTheFormula) {
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const FactoredGaussian g = random_gaussian(random);
    const Vec3 x = random.vector();
    const Mat3 covariance = g.covariance.matrix();
    const double distance = (x - g.mean).dot(covariance.inverse() * (x - g.mean));
    EXPECT_NEAR(squared_mahalanobis(g, x), distance, 1e-12 * (1 + distance));
    const double expected = -0.5 * (std::log((2 * std::numbers::pi * covariance).determinant()) + distance);
    EXPECT_NEAR(log_density(g, x), expected, 1e-12 * (1 + distance));
  }
}

double kl_divergence(const FactoredGaussian& a, const FactoredGaussian& b) {
  return internal::kl_divergence(expected_squared_mahalanobis(b.precision, a.mean - b.mean, a.covariance),
                                 a.log_determinant, b.log_determinant);
}

TEST(KlDivergence, IsTheIntegralOfItsDefinition) {
  Random random(3);
  for (int trial = 0; trial < 3; ++trial) {
    const FactoredGaussian a = random_gaussian(random, 0.2, 0.8), b = random_gaussian(random, 0.2, 0.8);
    const double integral = integrate([&](const Vec3& x) {
      const double log_a = log_density(a, x);
      return std::exp(log_a) * (log_a - log_density(b, x));
    });
    EXPECT_NEAR(kl_divergence(a, b), integral, 1e-5);
  }
}

TEST(KlDivergence, IsPositiveAndVanishesOnlyForEquals) {
  Random random(4);
  for (int trial = 0; trial < 1000; ++trial) {
    const FactoredGaussian a = random_gaussian(random), b = random_gaussian(random);
    EXPECT_GT(kl_divergence(a, b), 0);
    EXPECT_NEAR(kl_divergence(a, a), 0, 1e-12);
  }
}

TEST(KlDivergence, IsAffineInvariant) {
  Random random(5);
  for (int trial = 0; trial < 100; ++trial) {
    const FactoredGaussian a = random_gaussian(random), b = random_gaussian(random);
    const Mat3 map = random.matrix() + 2 * random.rotation();
    const auto mapped = [&](const FactoredGaussian& g) {
      return FactoredGaussian({map * g.mean + Vec3(1, 2, 3), congruence(map, g.covariance)});
    };
    const double before = kl_divergence(a, b);
    EXPECT_NEAR(kl_divergence(mapped(a), mapped(b)), before, 1e-10 * (1 + before));
  }
}

TEST(Bhattacharyya, IsTheIntegralOfTheGeometricMean) {
  Random random(6);
  for (int trial = 0; trial < 3; ++trial) {
    const FactoredGaussian a = random_gaussian(random, 0.2, 0.8), b = random_gaussian(random, 0.2, 0.8);
    const double integral =
        integrate([&](const Vec3& x) { return std::exp(0.5 * (log_density(a, x) + log_density(b, x))); });
    EXPECT_NEAR(std::exp(log_bhattacharyya(a, b)), integral, 1e-6);
  }
}

TEST(Bhattacharyya, IsSymmetricToTheLastBit) {
  Random random(7);
  for (int trial = 0; trial < 1000; ++trial) {
    const FactoredGaussian a = random_gaussian(random, 1e-6, 1), b = random_gaussian(random, 1e-6, 1);
    EXPECT_EQ(log_bhattacharyya(a, b), log_bhattacharyya(b, a));
    EXPECT_LE(log_bhattacharyya(a, b), 0);
    EXPECT_NEAR(log_bhattacharyya(a, a), 0, 1e-12);
  }
}

TEST(Bhattacharyya, IsAffineInvariant) {
  Random random(8);
  for (int trial = 0; trial < 100; ++trial) {
    const FactoredGaussian a = random_gaussian(random), b = random_gaussian(random);
    const Mat3 map = random.matrix() + 2 * random.rotation();
    const auto mapped = [&](const FactoredGaussian& g) {
      return FactoredGaussian({map * g.mean + Vec3(1, 2, 3), congruence(map, g.covariance)});
    };
    EXPECT_NEAR(log_bhattacharyya(mapped(a), mapped(b)), log_bhattacharyya(a, b), 1e-10);
  }
}

TEST(Bhattacharyya, StaysFiniteWhereTheCoefficientUnderflows) {
  const FactoredGaussian a({Vec3::Zero(), Sym3::identity(1e-6)}), b({Vec3(10, 0, 0), Sym3::identity(1e-6)});
  // -|Δμ|²/8σ²
  EXPECT_NEAR(log_bhattacharyya(a, b), -100 / 8e-6, 1e-6);
}

TEST(Product, IsTheNormalisedProductOfTheDensities) {
  Random random(9);
  for (int trial = 0; trial < 20; ++trial) {
    const FactoredGaussian a = random_gaussian(random), b = random_gaussian(random);
    const FactoredGaussian ab(product(a, b));
    const auto offset = [&](const Vec3& x) { return log_density(a, x) + log_density(b, x) - log_density(ab, x); };
    const double constant = offset(Vec3::Zero());
    for (int k = 0; k < 10; ++k) EXPECT_NEAR(offset(random.vector()), constant, 1e-10 * (1 + std::abs(constant)));
  }
}

}  // namespace
}  // namespace gpsrecon::test
