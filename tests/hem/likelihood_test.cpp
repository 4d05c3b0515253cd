#include <gpsrecon/core/error.h>
#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/hem/likelihood.h>
#include <gtest/gtest.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

/// Discs on a sphere, of deviations from 0.02 to 2 and all kinds of weights.
Mixture uneven_mixture() {
  test::Random random(7);
  const test::SampledShape sphere = test::random_sphere(300, 3);
  Mixture m;
  for (std::size_t i = 0; i < 300; ++i) {
    const double along = 0.02 * std::pow(100, random.uniform());
    m.means.push_back(sphere.points[i]);
    m.covariances.push_back(test::disc_covariance(sphere.normals[i], along, 0.2 * along));
    m.weights.push_back(random.uniform(0.1, 20));
  }
  return m;
}

std::vector<Vec3> places() {
  test::Random random(8);
  std::vector<Vec3> points;
  for (int i = 0; i < 500; ++i) points.push_back(random.vector(-1.5, 1.5));
  for (const Vec3& p : test::random_sphere(500, 9).points) points.push_back(p);
  points.emplace_back(1e3, 0, 0);
  return points;
}

/// ln of the sum of everything, without reach, logarithms or trees.
double brute_force(const Mixture& m, const Vec3& x, const LikelihoodOptions& o) {
  double total = 0, density = 0;
  for (const double w : m.weights) total += w;
  for (std::size_t s = 0; s < m.size(); ++s)
    density += m.weights[s] / total * std::exp(log_density(FactoredGaussian(m.component(s)), x));
  return std::log((1 - o.outlier_share) * density + o.outlier_share / o.outlier_volume);
}

TEST(Likelihood, IsTheSumOverAllComponents) {
  const Mixture m = uneven_mixture();
  const std::vector<Vec3> points = places();
  LikelihoodOptions options{.outlier_share = 0.02, .outlier_volume = 30};
  const std::vector<double> values = log_likelihoods(m, points, options);
  double peaks = 0, total = 0;
  for (std::size_t s = 0; s < m.size(); ++s) {
    peaks += m.weights[s] * std::exp(log_density(FactoredGaussian(m.component(s)), m.means[s]));
    total += m.weights[s];
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double all = brute_force(m, points[i], options);
    // What is out of reach is below exp(-reach²/2) of the densities at the means.
    EXPECT_LE(values[i], all + 1e-12) << i;
    EXPECT_GE(std::exp(values[i]), std::exp(all) - std::exp(-18.0) * peaks / total - 1e-12) << i;
  }
  options.reach = 12;
  const std::vector<double> farther = log_likelihoods(m, points, options);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_NEAR(farther[i], brute_force(m, points[i], options), 1e-11) << i;
}

TEST(Likelihood, OfAnOutlierIsThatOfTheUniformShare) {
  const std::vector<Vec3> far{{1e6, 0, 0}};
  EXPECT_NEAR(log_likelihoods(uneven_mixture(), far, {.outlier_share = 0.1, .outlier_volume = 4})[0], std::log(0.1 / 4),
              1e-12);
}

TEST(Likelihood, FollowsUnitsAndWeights) {
  const Mixture m = uneven_mixture();
  Mixture larger = m;
  for (Vec3& p : larger.means) p *= 4;
  for (Sym3& c : larger.covariances) c = c * 16.0;
  for (double& w : larger.weights) w *= 3;
  std::vector<Vec3> points = places();
  const std::vector<double> before = log_likelihoods(m, points, {.outlier_volume = 2});
  for (Vec3& p : points) p *= 4;
  const std::vector<double> after = log_likelihoods(larger, points, {.outlier_volume = 128});
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(after[i], before[i] - 3 * std::log(4), 1e-9) << i;
}

TEST(Likelihood, IsLargestForTheMixtureThePointsComeFrom) {
  const test::SampledShape sphere = test::fibonacci_sphere(400);
  test::Random random(4);
  std::vector<Vec3> points;
  for (int i = 0; i < 20000; ++i) points.push_back(sphere.points[random.below(400)] + 0.1 * random.normal3());
  const auto mean = [&](double deviation) {
    Mixture m;
    m.means = sphere.points;
    m.weights.assign(400, 1);
    m.covariances.assign(400, Sym3::identity(deviation * deviation));
    double sum = 0;
    for (const double value : log_likelihoods(m, points, {.outlier_volume = 8})) sum += value;
    return sum / static_cast<double>(points.size());
  };
  EXPECT_GT(mean(0.1), mean(0.08));
  EXPECT_GT(mean(0.1), mean(0.125));
}

TEST(Likelihood, DoesNotDependOnThreads) {
  const Mixture m = uneven_mixture();
  const std::vector<Vec3> points = places();
  RunContext one, three;
  one.threads = 1;
  three.threads = 3;
  EXPECT_EQ(log_likelihoods(m, points, {}, one), log_likelihoods(m, points, {}, three));
}

TEST(Likelihood, RefusesWhatHasNone) {
  const std::vector<Vec3> points = places();
  EXPECT_THROW(log_likelihoods({}, points), InvariantError);
  EXPECT_THROW(log_likelihoods(uneven_mixture(), points, {.outlier_share = 0}), OptionError);
  EXPECT_THROW(log_likelihoods(uneven_mixture(), points, {.outlier_volume = 0}), OptionError);
  EXPECT_THROW(log_likelihoods(uneven_mixture(), points, {.reach = 0}), OptionError);
}

}  // namespace
}  // namespace gpsrecon
