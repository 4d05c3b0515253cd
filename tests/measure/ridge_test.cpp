#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/measure/ridge.h>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;

Mixture mixture_of(const std::vector<Gaussian>& gaussians) {
  Mixture mixture;
  for (const Gaussian& g : gaussians) {
    mixture.means.push_back(g.mean);
    mixture.covariances.push_back(g.covariance);
    mixture.weights.push_back(1);
  }
  return mixture;
}

Mat3 random_rotation(Random& random) {
  return Eigen::AngleAxisd(random.uniform(0, 3), random.direction()).toRotationMatrix();
}

/// A crumpled sheet of flat Gaussians of different shapes, turned every way.
Mixture crumpled_sheet(Random& random, int n) {
  std::vector<Gaussian> gaussians;
  for (int i = 0; i < n; ++i) {
    const Vec3 mean(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.05, 0.05));
    const Mat3 tilt = Eigen::AngleAxisd(random.uniform(-0.3, 0.3), random.direction()).toRotationMatrix();
    gaussians.push_back({mean, congruence(tilt, Sym3::diagonal(random.uniform(0.02, 0.08), random.uniform(0.02, 0.08),
                                                               random.uniform(0.0005, 0.004)))});
  }
  return mixture_of(gaussians);
}

/// ln f, by its definition.
double log_density_of(const Mixture& mixture, const Vec3& x) {
  double sum = 0;
  for (std::size_t s = 0; s < mixture.size(); ++s)
    sum += mixture.weights[s] * std::exp(log_density(FactoredGaussian(mixture.component(s)), x));
  return std::log(sum);
}

TEST(Ridge, OfASingleFlatGaussianIsItsPlane) {
  Random random(1);
  const Mat3 axes = random_rotation(random);
  const Vec3 mean(3, -2, 5);
  const Mixture mixture = mixture_of({{mean, congruence(axes, Sym3::diagonal(1, 2, 0.01))}});
  std::vector<Vec3> points;
  points.reserve(200);
  for (int i = 0; i < 200; ++i)
    points.push_back(mean + axes * Vec3(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-0.5, 0.5)));
  const std::vector<RidgePoint> found = project_to_ridge(mixture, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 normal = axes.col(2);
    ASSERT_TRUE(found[i].on_ridge);
    ASSERT_LT((found[i].position - (points[i] - normal.dot(points[i] - mean) * normal)).norm(), 1e-10);
    ASSERT_NEAR(std::abs(found[i].across.dot(normal)), 1, 1e-12);
  }
}

// Balls of deviation s densely on a cylinder of radius R have the density exp(-(ρ² + R²) / 2s²) I₀(ρR / s²) at the
// distance ρ from the axis, largest where ρ = R I₁(ρR/s²) / I₀(ρR/s²). At a spacing h they miss it by the first
// harmonic of the lattice, of relative size exp(-2π² s²/h²).
TEST(Ridge, OfACylinderOfBallsIsAnalyticAndTheErrorFallsWithTheirSpacing) {
  constexpr double R = 1, s = 0.15;
  double rho = R;
  for (int i = 0; i < 200; ++i) {
    const double z = rho * R / (s * s);
    rho = R * std::cyl_bessel_i(1.0, z) / std::cyl_bessel_i(0.0, z);
  }
  ASSERT_LT(rho, R - 0.01);  // the ridge lies inside the cylinder, well outside the tolerance

  std::vector<double> errors;
  for (const double spacing : {2.0, 1.6, 1.3, 0.8}) {
    const double h = spacing * s;
    const int around = static_cast<int>(std::lround(2 * std::numbers::pi * R / h));
    const int half_height = static_cast<int>(std::ceil(9 * s / h));
    std::vector<Gaussian> gaussians;
    for (int k = -half_height; k <= half_height; ++k)
      for (int i = 0; i < around; ++i) {
        const double phi = 2 * std::numbers::pi * i / around;
        gaussians.push_back({Vec3(R * std::cos(phi), R * std::sin(phi), k * h), Sym3::identity(s * s)});
      }
    std::vector<Vec3> points;
    Random random(2);
    for (int i = 0; i < 50; ++i) {
      const double phi = random.uniform(0, 2 * std::numbers::pi), r = random.uniform(R - s, R + s);
      points.emplace_back(r * std::cos(phi), r * std::sin(phi), random.uniform(-h / 2, h / 2));
    }
    RidgeOptions options;
    options.tolerance = 1e-8;
    double largest = 0;
    for (const RidgePoint& p : project_to_ridge(mixture_of(gaussians), points, options)) {
      ASSERT_TRUE(p.on_ridge);
      largest = std::max(largest, std::abs(std::hypot(p.position.x(), p.position.y()) - rho));
    }
    errors.push_back(largest);
    EXPECT_LT(largest, s * std::exp(-2 * std::pow(std::numbers::pi / spacing, 2)) * 5 + 1e-7) << "spacing " << spacing;
  }
  for (std::size_t i = 1; i < errors.size(); ++i) EXPECT_LT(errors[i], errors[i - 1] / 3);
}

// By finite differences of the density itself: across is the direction of strongest downward curvature of ln f, and the
// gradient has no part along it.
TEST(Ridge, FulfilsItsDefinition) {
  Random random(3);
  const Mixture mixture = crumpled_sheet(random, 150);
  std::vector<Vec3> points;
  points.reserve(40);
  for (int i = 0; i < 40; ++i) points.emplace_back(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), 0.0);
  int checked = 0;
  for (const RidgePoint& p : project_to_ridge(mixture, points)) {
    if (!p.on_ridge) continue;
    ++checked;
    const double h = 1e-4;
    Vec3 gradient;
    Mat3 hessian;
    const auto at = [&](double a, int i, double b, int j) {
      Vec3 x = p.position;
      x[i] += a;
      x[j] += b;
      return log_density_of(mixture, x);
    };
    for (int i = 0; i < 3; ++i) {
      gradient[i] = (at(h, i, 0, i) - at(-h, i, 0, i)) / (2 * h);
      for (int j = 0; j < 3; ++j)
        hessian(i, j) = (at(h, i, h, j) - at(h, i, -h, j) - at(-h, i, h, j) + at(-h, i, -h, j)) / (4 * h * h);
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(hessian);
    ASSERT_LT(solver.eigenvalues()[0], 0);
    ASSERT_NEAR(std::abs(solver.eigenvectors().col(0).dot(p.across)), 1, 1e-4);
    // A step of 1e-6 deviations is left; differences are good to h² times third derivatives, (20/deviation)³.
    ASSERT_LT(std::abs(gradient.dot(p.across)) / std::sqrt(-solver.eigenvalues()[0]), 1e-3);
  }
  EXPECT_GE(checked, 30);
}

TEST(Ridge, MovesWithTheMixtureAndIsTheSameForAnyNumberOfThreads) {
  Random random(4);
  const Mixture mixture = crumpled_sheet(random, 150);
  std::vector<Vec3> points;
  points.reserve(300);
  for (int i = 0; i < 300; ++i)
    points.emplace_back(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), random.uniform(-0.05, 0.05));
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  const std::vector<RidgePoint> found = project_to_ridge(mixture, points, {}, one);
  const std::vector<RidgePoint> again = project_to_ridge(mixture, points, {}, four);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(found[i].position, again[i].position);
    ASSERT_EQ(found[i].on_ridge, again[i].on_ridge);
  }

  const Mat3 rotation = random_rotation(random);
  const Vec3 shift(100, -50, 20);
  const double scale = 1000;
  Mixture moved = mixture;
  for (Vec3& m : moved.means) m = scale * (rotation * m) + shift;
  for (Sym3& c : moved.covariances) c = scale * scale * congruence(rotation, c);
  std::vector<Vec3> moved_points;
  moved_points.reserve(points.size());
  for (const Vec3& p : points) moved_points.push_back(scale * (rotation * p) + shift);
  const std::vector<RidgePoint> moved_found = project_to_ridge(moved, moved_points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Where the direction jumps, rounding decides; there nothing comes to rest.
    if (!found[i].on_ridge || !moved_found[i].on_ridge) continue;
    ASSERT_LT((moved_found[i].position - (scale * (rotation * found[i].position) + shift)).norm(), 1e-6 * scale);
  }
}

// Each step goes to the maximum of a lower bound of the density that touches it where the step starts.
TEST(Ridge, NoStepLowersTheDensity) {
  Random random(5);
  const Mixture mixture = crumpled_sheet(random, 100);
  for (int i = 0; i < 30; ++i) {
    std::vector<Vec3> point = {{random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), random.uniform(-0.1, 0.1)}};
    double before = log_density_of(mixture, point[0]);
    RidgeOptions options;
    options.max_steps = 1;
    for (int step = 0; step < 20; ++step) {
      point[0] = project_to_ridge(mixture, point, options)[0].position;
      const double now = log_density_of(mixture, point[0]);
      ASSERT_GE(now, before - 1e-9);
      before = now;
    }
  }
}

TEST(Ridge, SaysWhichPointsDoNotReachIt) {
  const Mixture mixture = mixture_of({{Vec3::Zero(), Sym3::diagonal(1, 1, 0.01)}});
  const std::vector<Vec3> points = {{0, 0, 0.3}, {100, 0, 0}, {0, 0.2, -0.1}};
  const std::vector<RidgePoint> found = project_to_ridge(mixture, points);
  EXPECT_FALSE(found[1].on_ridge);
  EXPECT_EQ(found[1].position, points[1]);
  const RidgeDistance distance = ridge_distance(points, found);
  EXPECT_EQ(distance.lost, 1u);
  EXPECT_EQ(distance.distance.count, 2u);
  EXPECT_NEAR(distance.distance.mean, 0.2, 1e-12);
  EXPECT_NEAR(distance.distance.max, 0.3, 1e-12);

  // From beside two sheets one step is not enough.
  RidgeOptions options;
  options.max_steps = 1;
  const Mixture two =
      mixture_of({{Vec3(0, 0, 0), Sym3::diagonal(1, 1, 0.01)}, {Vec3(0, 0, 0.15), Sym3::diagonal(1, 1, 0.01)}});
  const std::vector<Vec3> beside = {{0, 0, 0.3}};
  EXPECT_FALSE(project_to_ridge(two, beside, options)[0].on_ridge);
  const RidgePoint between = project_to_ridge(two, beside)[0];
  EXPECT_TRUE(between.on_ridge);
  EXPECT_NEAR(between.position.z(), 0.075, 1e-5);  // the middle, by symmetry; 0.15 is less than two deviations
}

// Where a step leads into the reach of components that are out of reach where it starts.
TEST(Ridge, SeesTheComponentsAroundEachPlaceItComesTo) {
  const Mixture mixture = mixture_of(
      {{Vec3(0, 0, 0), Sym3::diagonal(1, 1, 0.25)}, {Vec3(0, 0, 0.1), Sym3::diagonal(0.0025, 0.0025, 0.0016)}});
  const std::vector<Vec3> points = {{0, 0, 2}, {0, 0, 0.15}};
  const std::vector<RidgePoint> found = project_to_ridge(mixture, points);
  ASSERT_TRUE(found[0].on_ridge && found[1].on_ridge);
  EXPECT_GT(found[1].position.z(), 0.09);
  EXPECT_NEAR(found[0].position.z(), found[1].position.z(), 1e-6);
}

// In the middle of six balls the density is smallest: the gradient vanishes there, but that is no ridge.
TEST(Ridge, IsNotWhereTheDensityIsSmallest) {
  std::vector<Gaussian> balls;
  for (int k = 0; k < 3; ++k)
    for (const double side : {-3.0, 3.0}) balls.push_back({side * Vec3::Unit(k), Sym3::identity()});
  const std::vector<Vec3> middle = {Vec3::Zero()};
  EXPECT_FALSE(project_to_ridge(mixture_of(balls), middle)[0].on_ridge);
}

TEST(Ridge, RefusesWhatHasNone) {
  const std::vector<Vec3> points = {Vec3::Zero()};
  EXPECT_THROW(project_to_ridge({}, points), InvariantError);
  const Mixture mixture = mixture_of({{Vec3::Zero(), Sym3::diagonal(1, 1, 0.01)}});
  EXPECT_THROW(project_to_ridge(mixture, std::vector<Vec3>{{0, std::nan(""), 0}}), InvariantError);
  const auto throws_naming = [&](RidgeOptions options, const char* field) {
    EXPECT_THAT([&] { project_to_ridge(mixture, points, options); },
                testing::ThrowsMessage<OptionError>(testing::HasSubstr(field)));
  };
  throws_naming({.max_steps = 0}, "max_steps");
  throws_naming({.tolerance = 0}, "tolerance");
  throws_naming({.reach = 2}, "reach");
}

}  // namespace
}  // namespace gpsrecon
