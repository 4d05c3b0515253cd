#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/clean.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/core/scale.h>
#include <gpsrecon/hem/hem.h>
#include <Eigen/LU>
#include <cstring>

#include "support/same_bytes.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Moments;
using test::moments;
using test::Random;
using test::same_bytes;
using testing::HasSubstr;
using testing::ThrowsMessage;

PointCloud random_cloud(std::size_t n, std::uint64_t seed) {
  return test::cloud_of(Random(seed).vectors(n, -0.5, 0.5));
}

/// The reduction as it is published: from balls, without levels that only merge in flat places.
HemOptions published(HemOptions options) {
  options.flat_levels = 0;
  options.initial = InitialCovariance::isotropic;
  return options;
}

/// All levels, level 0 first.
std::vector<Mixture> levels(const PointCloud& cloud, HemOptions options, const RunContext& context = {}) {
  std::vector<Mixture> found;
  options.on_level = [&found](int level, const Mixture& m) {
    EXPECT_EQ(level, static_cast<int>(found.size()));
    found.push_back(m);
  };
  build_mixture(cloud, options, context);
  return found;
}

bool same_bytes(const Mixture& a, const Mixture& b) {
  return same_bytes(a.means, b.means) && same_bytes(a.covariances, b.covariances) && same_bytes(a.weights, b.weights) &&
         same_bytes(a.normals, b.normals) && same_bytes(a.normal_variances, b.normal_variances);
}

/// One level by the equations as they are printed (Preiner et al. 2019, appendix A; 2014, Eq. 9-11, 29-30), over all
/// pairs, with dense matrices and raw moments.
struct BruteLevel {
  Mixture next;
  std::vector<char> orphan;        ///< per component of `next`
  std::vector<Index> from;         ///< per component of `next`: the parent or orphan
  Eigen::MatrixXd responsibility;  ///< component of the level × component
};
BruteLevel brute_level(const Mixture& m, int number, const HemOptions& options, std::uint64_t seed) {
  const auto n = static_cast<Eigen::Index>(m.size());
  const auto at = [](Eigen::Index i) { return static_cast<std::size_t>(i); };
  std::vector<bool> parent;
  for (Eigen::Index i = 0; i < n; ++i)
    parent.push_back(random_uniform(seed, static_cast<std::uint64_t>(number), at(i)) < options.parent_probability);
  const double minus_infinity = -std::numeric_limits<double>::infinity();
  Eigen::MatrixXd log_joint = Eigen::MatrixXd::Constant(n, n, minus_infinity);  // ln(w_s L(s | i)) at (i, s)
  for (Eigen::Index s = 0; s < n; ++s) {
    if (!parent[at(s)]) continue;
    const Mat3 covariance = m.covariances[at(s)].matrix(), inverse = covariance.inverse();
    for (Eigen::Index i = 0; i < n; ++i) {
      if (parent[at(i)]) continue;
      const Mat3 child = m.covariances[at(i)].matrix();
      const Vec3 d = m.means[at(i)] - m.means[at(s)];
      const double mahalanobis = d.dot(inverse * d), trace = (inverse * child).trace();
      const double divergence =
          0.5 * (mahalanobis + trace - 3 - std::log(child.determinant() / covariance.determinant()));
      if (divergence > options.alpha * options.alpha / 2) continue;
      const double log_f = -0.5 * (std::log((2 * std::numbers::pi * covariance).determinant()) + mahalanobis);
      log_joint(i, s) = std::log(m.weights[at(s)]) + m.weights[at(i)] * (log_f - 0.5 * trace);
    }
  }
  BruteLevel result;
  result.responsibility = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double largest = log_joint.row(i).maxCoeff();
    if (largest == minus_infinity) continue;
    result.responsibility.row(i) = (log_joint.row(i).array() - largest).exp();
    result.responsibility.row(i) /= result.responsibility.row(i).sum();
  }
  for (Eigen::Index s = 0; s < n; ++s)
    if (parent[at(s)]) result.responsibility(s, s) = 1;

  for (Eigen::Index s = 0; s < n; ++s) {
    const bool orphan = !parent[at(s)] && result.responsibility.row(s).isZero(0);
    if (!parent[at(s)] && !orphan) continue;
    double weight = orphan ? m.weights[at(s)] : 0;
    for (Eigen::Index i = 0; i < n; ++i) weight += result.responsibility(i, s) * m.weights[at(i)];
    Vec3 mean = Vec3::Zero(), axis = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    double variance = 0;
    const auto accumulate = [&](Eigen::Index i, double share) {
      mean += share * m.means[at(i)];
      second += share * (m.covariances[at(i)].matrix() + m.means[at(i)] * m.means[at(i)].transpose());
      if (m.normals.empty()) return;
      const double side = m.normals[at(i)].dot(m.normals[at(s)]) < 0 ? -1 : 1;
      axis += share * side * m.normals[at(i)];
      variance += share * m.normal_variances[at(i)];
    };
    if (orphan) accumulate(s, 1);
    for (Eigen::Index i = 0; i < n; ++i)
      if (result.responsibility(i, s) > 0) accumulate(i, result.responsibility(i, s) * m.weights[at(i)] / weight);
    result.from.push_back(static_cast<Index>(s));
    result.orphan.push_back(orphan ? 1 : 0);
    result.next.means.push_back(mean);
    result.next.covariances.push_back(Sym3::from_matrix(second - mean * mean.transpose()));
    result.next.weights.push_back(weight);
    if (m.normals.empty()) continue;
    result.next.normals.push_back(axis.normalized());
    result.next.normal_variances.push_back(variance - 2 * std::log(axis.norm()));
  }
  return result;
}

void expect_levels_by_brute_force(const PointCloud& cloud, const HemOptions& options, std::uint64_t seed) {
  RunContext context;
  context.seed = seed;
  const std::vector<Mixture> all = levels(cloud, options, context);
  ASSERT_GE(all.size(), 2U);
  const double diagonal = bounding_box_diagonal(cloud.positions);
  std::size_t orphans = 0, merged = 0;
  for (std::size_t l = 0; l + 1 < all.size(); ++l) {
    const Mixture& next = all[l + 1];
    const BruteLevel brute = brute_level(all[l], static_cast<int>(l + 1), options, seed);
    ASSERT_EQ(next.size(), brute.next.size()) << "level " << l + 1;
    for (std::size_t s = 0; s < next.size(); ++s) {
      // The floor of the eigenvalues is not part of the equations; it must not be active here.
      const Vec3 values = eigen_decomposition(next.covariances[s]).values;
      ASSERT_GT(values[0], 2e-6 * values[2]);
      EXPECT_NEAR(next.weights[s], brute.next.weights[s], 1e-10 * brute.next.weights[s]);
      EXPECT_LT((next.means[s] - brute.next.means[s]).norm(), 1e-10 * diagonal);
      EXPECT_LT((next.covariances[s].matrix() - brute.next.covariances[s].matrix()).norm(), 1e-10 * values[2]);
      if (!next.normals.empty()) {
        EXPECT_LT((next.normals[s] - brute.next.normals[s]).norm(), 1e-10);
        EXPECT_NEAR(next.normal_variances[s], brute.next.normal_variances[s], 1e-10);
      }
      if (brute.orphan[s]) {
        EXPECT_EQ(next.means[s], all[l].means[brute.from[s]]);
        EXPECT_EQ(next.covariances[s], all[l].covariances[brute.from[s]]);
        EXPECT_EQ(next.weights[s], all[l].weights[brute.from[s]]);
      }
      orphans += brute.orphan[s] ? 1 : 0;
    }
    merged += all[l].size() - next.size();
  }
  EXPECT_GT(orphans, 0U);
  EXPECT_GT(merged, cloud.size() / 5);
}

TEST(Hem, OneLevelIsThatOfTheEquations) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    expect_levels_by_brute_force(random_cloud(300, 100 + seed),
                                 published({.sigma0 = Length::scene(0.06), .max_levels = 1}), seed);
}

TEST(Hem, AllLevelsAreThoseOfTheEquations) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (const double alpha : {1.4, 2.0, 2.6})
      expect_levels_by_brute_force(random_cloud(250, 110 + seed),
                                   published({.sigma0 = Length::scene(0.07), .alpha = alpha}), seed);
}

TEST(Hem, LevelsWithWeightsNormalsAndLocalCovariancesAreThoseOfTheEquations) {
  Random random(120);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    test::SampledShape sphere = test::random_sphere(350, 130 + seed, 0.5);
    add_noise(sphere, 0.01, 140 + seed);
    PointCloud cloud = sphere.cloud();
    cloud.normals = sphere.normals;
    for (Vec3& n : cloud.normals) n = (random.uniform() < 0.5 ? -1 : 1) * (n + 0.2 * random.normal3()).normalized();
    for (std::size_t i = 0; i < cloud.size(); ++i) cloud.weights.push_back(1 + static_cast<double>(random.below(4)));
    for (const InitialCovariance initial : {InitialCovariance::isotropic, InitialCovariance::local})
      expect_levels_by_brute_force(cloud,
                                   {.sigma0 = Length::scene(0.03),
                                    .spacing = Length::scene(0.05),
                                    .parent_probability = 0.4,
                                    .flat_levels = 0,
                                    .initial = initial,
                                    .normals = true},
                                   seed);
  }
}

TEST(Hem, LikelihoodsBeyondTheRangeOfNumbersAreThoseOfTheEquations) {
  // A likelihood is a power of the weight of the child: for heavy points exp() of its logarithm is 0 or infinite.
  for (const double unit : {1e-3, 1.0, 1e3}) {
    PointCloud cloud = random_cloud(300, 145);
    Random random(146);
    for (Vec3& p : cloud.positions) p *= unit;
    for (std::size_t i = 0; i < cloud.size(); ++i) cloud.weights.push_back(300 + random.uniform(0, 300));
    expect_levels_by_brute_force(cloud, published({.sigma0 = Length::scene(0.07 * unit)}), 1);
  }
}

TEST(Hem, WeightMeanAndCovarianceAreConserved) {
  test::SampledShape shape = test::random_sphere(20000, 150, 0.5);
  add_noise(shape, 0.01, 151);
  PointCloud cloud = shape.cloud();
  Random random(152);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.weights.push_back(0.5 + random.uniform());
  for (const bool balance : {false, true}) {
    const std::vector<Mixture> all = levels(cloud, published({.balance = balance}));
    ASSERT_GE(all.size(), 4U);
    const Moments start = moments(all[0]);
    EXPECT_NEAR(start.weight, std::accumulate(cloud.weights.begin(), cloud.weights.end(), 0.0), 1e-12 * start.weight);
    for (const Mixture& level : all) {
      ASSERT_NO_THROW(validate(level));
      for (const Sym3& covariance : level.covariances) {
        const Vec3 values = eigen_decomposition(covariance).values;
        ASSERT_GT(values[0], 2e-6 * values[2]);  // the floor is inactive
      }
      // Coordinates are below one and every sum is of positive shares, so that rounding adds up to a few ε per level.
      const Moments now = moments(level);
      EXPECT_NEAR(now.weight, start.weight, 1e-12 * start.weight);
      EXPECT_LT((now.mean - start.mean).norm(), 1e-13);
      EXPECT_LT((now.covariance - start.covariance).norm(), 1e-13);
    }
  }
}

TEST(Hem, SheetsBeyondTheDivergenceBoundNeverMix) {
  // For sheets z = ±g/2 all covariances have σ0² as their z entry, as no z moves. D_KL >= d_M²/2 >= (g/σ0)²/2.
  const double gap = 0.2, alpha = 2, sigma0 = 0.999 * gap / alpha;
  const test::SampledShape sheets = test::two_sheets(2000, 2, gap, 160);
  for (const Mixture& level : levels(sheets.cloud(), published({.sigma0 = Length::scene(sigma0), .alpha = alpha}))) {
    double lower = 0;
    for (std::size_t s = 0; s < level.size(); ++s) {
      EXPECT_NEAR(std::abs(level.means[s].z()), gap / 2, 1e-14);
      EXPECT_NEAR(level.covariances[s].zz, sigma0 * sigma0, 1e-14);
      if (level.means[s].z() < 0) lower += level.weights[s];
    }
    EXPECT_NEAR(lower, 2000, 2000 * 1e-12);
  }
}

TEST(Hem, PairWithinTheBoundMergesAndBeyondItDoesNot) {
  // Two equal Gaussians: D_KL = d²/(2σ²), so they merge up to d = ασ.
  RunContext context;
  for (context.seed = 1;
       !(random_uniform(context.seed, 1, 0) < 1.0 / 3 && random_uniform(context.seed, 1, 1) >= 1.0 / 3);)
    ++context.seed;
  for (const double alpha : {0.5, 2.0, 3.0}) {
    PointCloud pair;
    pair.positions = {Vec3(0, 0, 0), Vec3(0, 0.6, 0.8) * (alpha * 0.25 * (1 - 1e-9))};
    const Mixture merged =
        build_mixture(pair, published({.sigma0 = Length::scene(0.25), .alpha = alpha, .max_levels = 1}), context);
    ASSERT_EQ(merged.size(), 1U);
    EXPECT_EQ(merged.weights[0], 2.0);
    EXPECT_LT((merged.means[0] - 0.5 * pair.positions[1]).norm(), 1e-15);
    const Sym3 expected = Sym3::identity(0.0625) + 0.25 * Sym3::outer(pair.positions[1]);
    EXPECT_LT((merged.covariances[0].matrix() - expected.matrix()).norm(), 1e-15);
    pair.positions[1] *= 1 + 2e-9;
    EXPECT_EQ(build_mixture(pair, published({.sigma0 = Length::scene(0.25), .alpha = alpha, .max_levels = 1}), context)
                  .size(),
              2U);
  }
}

TEST(Hem, NormalVarianceOfTwoUnitVectors) {
  // Eq. 30 for two normals at angle φ: resultant cos(φ/2), total variance -2 ln cos(φ/2), about φ²/4, their axis
  // halfway.
  RunContext context;
  for (context.seed = 1;
       !(random_uniform(context.seed, 1, 0) < 1.0 / 3 && random_uniform(context.seed, 1, 1) >= 1.0 / 3);)
    ++context.seed;
  PointCloud pair;
  pair.positions = {Vec3(0, 0, 0), Vec3(0.1, 0, 0)};
  for (const double angle : {0.0, 0.3, 1.0, 1.5})
    for (const double side : {-1.0, 1.0}) {
      pair.normals = {Vec3::UnitZ(), side * Vec3(std::sin(angle), 0, std::cos(angle))};
      const Mixture m = build_mixture(pair, published({.sigma0 = Length::scene(0.25), .normals = true}), context);
      ASSERT_EQ(m.size(), 1U);
      EXPECT_NEAR(m.normal_variances[0], -2 * std::log(std::cos(angle / 2)), 1e-14);
      EXPECT_LT((m.normals[0] - Vec3(std::sin(angle / 2), 0, std::cos(angle / 2))).norm(), 1e-14);
    }
}

TEST(Hem, WrappedNormalsOnTheUnitSphere) {
  // With normal = position the resultant is the merged mean: axis = μ/|μ| and variance = -2 ln|μ| after one level.
  PointCloud cloud = test::random_sphere(3000, 170).cloud();
  cloud.normals = cloud.positions;
  const std::vector<Mixture> all = levels(cloud, published({.normals = true}));
  ASSERT_GE(all.size(), 3U);
  for (std::size_t s = 0; s < all[1].size(); ++s) {
    EXPECT_LT((all[1].normals[s] - all[1].means[s].normalized()).norm(), 1e-12);
    EXPECT_NEAR(all[1].normal_variances[s], std::max(0.0, -2 * std::log(all[1].means[s].norm())), 1e-12);
  }
  // Later, axes are averaged as if all components had the same |μ|; the spread of that bounds the angle.
  for (std::size_t l = 2; l < all.size(); ++l) {
    double shortest = 1;
    for (const Vec3& mean : all[l].means) shortest = std::min(shortest, mean.norm());
    for (std::size_t s = 0; s < all[l].size(); ++s) {
      EXPECT_LT((all[l].normals[s] - all[l].means[s].normalized()).norm(), 1 - shortest);
      EXPECT_GE(all[l].normal_variances[s], 0);
    }
  }
}

TEST(Hem, FlippingNormalsChangesNothingButTheirSign) {
  PointCloud cloud = test::random_sphere(2000, 171).cloud();
  cloud.normals = cloud.positions;
  const Mixture reference = build_mixture(cloud, published({.normals = true}));
  Random random(172);
  for (Vec3& n : cloud.normals)
    if (random.uniform() < 0.5) n = -n;
  const Mixture flipped = build_mixture(cloud, published({.normals = true}));
  EXPECT_TRUE(same_bytes(flipped.means, reference.means));
  EXPECT_TRUE(same_bytes(flipped.covariances, reference.covariances));
  EXPECT_TRUE(same_bytes(flipped.normal_variances, reference.normal_variances));
  ASSERT_EQ(flipped.normals.size(), reference.normals.size());
  for (std::size_t s = 0; s < flipped.size(); ++s)
    EXPECT_TRUE(flipped.normals[s] == reference.normals[s] || flipped.normals[s] == -reference.normals[s]);
}

TEST(Hem, NormalsDoNotInfluenceTheClustering) {
  const PointCloud cloud = test::random_sphere(1000, 173).cloud();
  const Mixture with = build_mixture(cloud, published({.normals = true})),
                without = build_mixture(cloud, published({}));
  EXPECT_TRUE(same_bytes(with.means, without.means));
  EXPECT_TRUE(same_bytes(with.covariances, without.covariances));
}

TEST(Hem, ParentsAreDrawnWithTheGivenProbability) {
  // All points within reach of each other: only parents remain, and parents never absorb parents.
  PointCloud cloud = random_cloud(4000, 180);
  for (Vec3& p : cloud.positions) p *= 1e-3;
  for (const double probability : {0.1, 1.0 / 3, 0.7}) {
    RunContext context;
    context.seed = 5;
    const Mixture m = build_mixture(
        cloud, published({.sigma0 = Length::scene(1), .parent_probability = probability, .max_levels = 1}), context);
    std::size_t drawn = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) drawn += random_uniform(5, 1, i) < probability ? 1 : 0;
    EXPECT_EQ(m.size(), drawn);
    EXPECT_NEAR(static_cast<double>(drawn), 4000 * probability, 4 * std::sqrt(4000 * probability * (1 - probability)));
  }
}

TEST(Hem, StopsBeforeALevelThatRemovesTooLittle) {
  const PointCloud cloud = random_cloud(400, 181);
  for (const double min_reduction : {0.025, 0.2, 0.45}) {
    const HemOptions options = published({.sigma0 = Length::scene(0.05), .min_reduction = min_reduction});
    const std::vector<Mixture> all = levels(cloud, options);
    for (std::size_t l = 1; l < all.size(); ++l)
      EXPECT_LE(static_cast<double>(all[l].size()), (1 - min_reduction) * static_cast<double>(all[l - 1].size()));
    const BruteLevel next = brute_level(all.back(), static_cast<int>(all.size()), options, RunContext{}.seed);
    EXPECT_GT(static_cast<double>(next.next.size()), (1 - min_reduction) * static_cast<double>(all.back().size()));
  }
}

TEST(Hem, LargestNumberOfLevels) {
  const PointCloud cloud = random_cloud(2000, 182);
  const std::vector<Mixture> all = levels(cloud, published({.sigma0 = Length::scene(0.1)}));
  ASSERT_GE(all.size(), 4U);
  for (int l = 1; l < 3; ++l) {
    const Mixture m = build_mixture(cloud, published({.sigma0 = Length::scene(0.1), .max_levels = l}));
    EXPECT_TRUE(same_bytes(m, all[static_cast<std::size_t>(l)]));
  }
}

TEST(Hem, TargetCountIsHit) {
  const PointCloud cloud = test::random_sphere(6000, 183).cloud();
  const double least = static_cast<double>(build_mixture(cloud, published({})).size());
  for (const double target : {1.3 * least, 1000.0, 1999.0, 2500.0, 4700.0}) {
    ASSERT_GT(target, least);
    const Mixture m = build_mixture(cloud, published({.target_components = static_cast<std::size_t>(target)}));
    EXPECT_NEAR(static_cast<double>(m.size()), target, 0.02 * target);
    EXPECT_NEAR(std::accumulate(m.weights.begin(), m.weights.end(), 0.0), 6000, 6000 * 1e-12);
    ASSERT_NO_THROW(validate(m));
  }
}

TEST(Hem, TargetBeyondTheCloudKeepsThePoints) {
  const PointCloud cloud = random_cloud(100, 184);
  for (const std::size_t target : {100, 101, 100000}) {
    const Mixture m = build_mixture(cloud, published({.sigma0 = Length::scene(0.2), .target_components = target}));
    EXPECT_EQ(m.means, cloud.positions);
  }
}

TEST(Hem, SeedsDecide) {
  const PointCloud cloud = random_cloud(1000, 185);
  RunContext one, other;
  one.seed = 7, other.seed = 8;
  const HemOptions options = published({.sigma0 = Length::scene(0.1)});
  EXPECT_TRUE(same_bytes(build_mixture(cloud, options, one), build_mixture(cloud, options, one)));
  EXPECT_FALSE(same_bytes(build_mixture(cloud, options, one), build_mixture(cloud, options, other)));
}

TEST(Hem, SameBytesForAnyNumberOfThreads) {
  test::SampledShape shape = test::random_sphere(20000, 186);
  add_noise(shape, 0.005, 187);
  for (const InitialCovariance initial : {InitialCovariance::isotropic, InitialCovariance::local}) {
    const HemOptions options{.flat_levels = 0, .initial = initial, .balance = true, .normals = true};
    RunContext context;
    context.threads = 1;
    const Mixture reference = build_mixture(shape.cloud(), options, context);
    for (const int threads : {2, 4, 8}) {
      context.threads = threads;
      EXPECT_TRUE(same_bytes(build_mixture(shape.cloud(), options, context), reference)) << threads;
    }
  }
}

/// What the whole beginning of the chain makes of points in world coordinates.
Mixture from_world(const std::vector<Vec3>& points, const HemOptions& options = published({})) {
  PointCloud cloud;
  cloud.positions = points;
  return build_mixture(clean(cloud).cloud, options);
}

std::vector<Vec3> transformed(std::vector<Vec3> points, double scale, const Vec3& shift) {
  for (Vec3& p : points) p = scale * p + shift;
  return points;
}

TEST(Hem, PowersOfTwoChangeNoLocalByte) {
  const std::vector<Vec3> points = test::random_sphere(2000, 190, 1, Vec3(0.1, 3, -0.7)).points;
  const Mixture reference = from_world(points);
  for (const int k : {-30, -1, 1, 10, 40})
    EXPECT_TRUE(same_bytes(from_world(transformed(points, std::ldexp(1.0, k), Vec3::Zero())), reference)) << k;
}

TEST(Hem, UnitsOfAThousandthKeepCountsAndPositions) {
  for (const InitialCovariance initial : {InitialCovariance::isotropic, InitialCovariance::local})
    for (std::uint64_t seed = 191; seed < 195; ++seed) {
      const std::vector<Vec3> points = test::random_sphere(5000, seed, 0.7, Vec3(0.1, 3, -0.7)).points;
      const Mixture metres = from_world(points, {.flat_levels = 0, .initial = initial});
      const Mixture millimetres =
          from_world(transformed(points, 1000, Vec3::Zero()), {.flat_levels = 0, .initial = initial});
      ASSERT_EQ(millimetres.size(), metres.size());
      for (std::size_t s = 0; s < metres.size(); ++s) {
        EXPECT_LT(
            (millimetres.frame.to_world(millimetres.means[s]) / 1000 - metres.frame.to_world(metres.means[s])).norm(),
            1e-9);
        EXPECT_NEAR(millimetres.weights[s], metres.weights[s], 1e-9 * metres.weights[s]);
      }
    }
}

TEST(Hem, SurveyCoordinatesKeepCountsAndPositions) {
  // An object of two metres far from the origin of its coordinates, which there resolve 1e-9 m.
  const Vec3 offset(6e5, 5e6, 300);
  for (std::uint64_t seed = 195; seed < 199; ++seed) {
    const std::vector<Vec3> points = test::random_sphere(5000, seed).points;
    const Mixture near = from_world(points), far = from_world(transformed(points, 1, offset));
    ASSERT_EQ(far.size(), near.size());
    const double diagonal = bounding_box_diagonal(points);
    for (std::size_t s = 0; s < near.size(); ++s)
      EXPECT_LT((far.frame.to_world(far.means[s]) - offset - near.frame.to_world(near.means[s])).norm(),
                1e-6 * diagonal);
  }
}

TEST(Hem, OrderOfTheInputChangesNoByte) {
  std::vector<Vec3> points = test::random_sphere(3000, 200).points;
  const Mixture reference = from_world(points);
  Random random(201);
  for (int trial = 0; trial < 3; ++trial) {
    random.shuffle(points);
    EXPECT_TRUE(same_bytes(from_world(points), reference));
  }
}

TEST(Hem, EveryPointTwiceIsTwiceTheWeight) {
  const std::vector<Vec3> points = test::random_sphere(2000, 202).points;
  std::vector<Vec3> twice = points;
  twice.insert(twice.end(), points.begin(), points.end());
  PointCloud weighted;
  weighted.positions = points;
  weighted.weights.assign(points.size(), 2.0);
  EXPECT_TRUE(same_bytes(from_world(twice), build_mixture(clean(weighted).cloud, published({}))));
}

TEST(Hem, FewPoints) {
  EXPECT_THROW(build_mixture(PointCloud{}, published({.sigma0 = Length::scene(1)})), NoSurfaceError);
  for (std::size_t n = 1; n <= 3; ++n) {
    const PointCloud cloud = random_cloud(n, 210);
    const Mixture m = build_mixture(cloud, published({.sigma0 = Length::scene(0.1)}));
    ASSERT_NO_THROW(validate(m));
    EXPECT_NEAR(std::accumulate(m.weights.begin(), m.weights.end(), 0.0), static_cast<double>(n), 1e-14);
    if (n < 3) {
      EXPECT_THROW(build_mixture(cloud, published({})), NoSurfaceError);
    } else {
      EXPECT_NO_THROW(build_mixture(cloud, published({})));
    }
  }
}

TEST(Hem, EqualPointsHaveNoSpacing) {
  PointCloud cloud;
  cloud.positions.assign(20, Vec3(0.5, 0.25, 0));
  EXPECT_THROW(build_mixture(cloud, published({})), NoSurfaceError);
}

TEST(Hem, PointsOnALineStayThereAndTheFloorHolds) {
  // With a wide reach components grow to the whole line, 3000 times as long as wide: the floor of the smallest
  // eigenvalue widens them across, evenly.
  const Vec3 axis = Vec3(1, 2, 2) / 3;
  PointCloud cloud;
  for (int i = 0; i < 4000; ++i) cloud.positions.push_back(i / 4000.0 * axis);
  const Mixture m = build_mixture(cloud, published({.sigma0 = Length::scene(1e-4), .alpha = 10, .min_reduction = 0}));
  ASSERT_NO_THROW(validate(m));
  EXPECT_NEAR(moments(m).weight, 4000, 4000 * 1e-12);
  double flattest = 1;
  for (std::size_t s = 0; s < m.size(); ++s) {
    EXPECT_LT(m.means[s].cross(axis).norm(), 1e-14);
    const Eigen3 e = eigen_decomposition(m.covariances[s]);
    EXPECT_NEAR(std::abs(e.vectors.col(2).dot(axis)), 1, 1e-12);
    EXPECT_NEAR(e.values[0], e.values[1], 1e-12 * e.values[2]);
    flattest = std::min(flattest, e.values[0] / e.values[2]);
  }
  EXPECT_NEAR(flattest, 1e-6, 1e-12);
}

TEST(Hem, MoreDetailFromASmallerKernel) {
  const PointCloud cloud = test::random_sphere(5000, 211).cloud();
  const double sigma0 = estimate_scale(cloud).sigma0;
  std::size_t before = 0;
  for (const double factor : {4.0, 2.0, 1.0, 0.5}) {
    const std::size_t count = build_mixture(cloud, published({.sigma0 = Length::scene(factor * sigma0)})).size();
    EXPECT_GT(count, before);
    before = count;
  }
}

/// How many components of a mixture lie at x < 0, and how many do not.
std::pair<std::size_t, std::size_t> left_and_right(const Mixture& m) {
  std::size_t left = 0;
  for (const Vec3& mean : m.means) left += mean.x() < 0 ? 1 : 0;
  return {left, m.size() - left};
}

TEST(Hem, FlatLevelsThinOutWhatIsFlat) {
  // A sheet, flat at x < 0 and with ripples narrower than a few Gaussians at x > 0.
  PointCloud cloud = test::rectangle(12000, 4, 2, 31).cloud();
  for (Vec3& p : cloud.positions)
    if (p.x() > 0) p.z() = 0.06 * (1 - std::cos(12 * p.x()));
  // Crests and troughs are flat, too: at kernels of 0.4 to 1.6 spacings a fifth to a quarter of the rippled ones goes,
  // and two fifths to a half of the flat ones.
  const HemOptions plain{.sigma0 = Length::parse("0.5sp"), .flat_levels = 0, .initial = InitialCovariance::local};
  HemOptions flat = plain;
  flat.flat_levels = 4;
  const auto without = left_and_right(build_mixture(cloud, plain)), with = left_and_right(build_mixture(cloud, flat));
  EXPECT_LT(with.first, 0.7 * without.first);
  EXPECT_GT(with.second, 0.75 * without.second);
  EXPECT_NEAR(moments(build_mixture(cloud, flat)).weight, 12000, 1e-8);
}

TEST(Hem, FlatLevelsLeavePiecesOfThree) {
  // Every parent of such a level would take the others of its piece.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    PointCloud cloud;
    for (const Vec3& at : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}) cloud.positions.push_back(at);
    RunContext context;
    context.seed = seed;
    // No level but flat ones: alpha is too small for others.
    const HemOptions options{
        .sigma0 = Length::scene(1), .alpha = 1e-3, .flat_levels = 4, .initial = InitialCovariance::isotropic};
    EXPECT_EQ(build_mixture(cloud, options, context).size(), 3U);
  }
  PointCloud many = test::rectangle(60, 8, 8, 5).cloud();
  EXPECT_LT(
      build_mixture(
          many, {.sigma0 = Length::scene(1), .alpha = 1e-3, .flat_levels = 4, .initial = InitialCovariance::isotropic})
          .size(),
      50U);
}

TEST(Hem, CancelStops) {
  std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  EXPECT_THROW(build_mixture(random_cloud(100, 212), published({.sigma0 = Length::scene(0.1)}), context), Cancelled);
}

TEST(Hem, OptionsOutOfRangeNameTheField) {
  const PointCloud cloud = random_cloud(50, 213);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto expect = [&](const HemOptions& options, const char* field) {
    EXPECT_THAT([&] { build_mixture(cloud, options); }, ThrowsMessage<OptionError>(HasSubstr(field))) << field;
  };
  for (const double bad : {-1.0, nan, inf}) {
    expect({.sigma0 = Length::scene(bad)}, "sigma0");
    expect({.spacing = Length::scene(bad)}, "spacing");
    expect({.alpha = bad}, "alpha");
    expect({.parent_probability = bad}, "parent-probability");
    expect({.min_reduction = bad}, "min-reduction");
  }
  expect({.alpha = 0}, "alpha");
  expect({.alpha = 10.5}, "alpha");
  expect({.parent_probability = 0}, "parent-probability");
  expect({.parent_probability = 1}, "parent-probability");
  expect({.min_reduction = 1}, "min-reduction");
  expect({.max_levels = -1}, "hem-levels");
  expect({.neighbors = 3}, "neighbors");
  expect({.neighbors = 1001}, "neighbors");
  expect({.alpha = 77}, "77");
}

}  // namespace
}  // namespace gpsrecon
