#include <gpsrecon/core/error.h>
#include <gpsrecon/measure/statistics.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/meshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

std::vector<double> random_values(std::size_t n) {
  Random random(31);
  std::vector<double> values(n);
  for (double& v : values) v = std::exp(random.uniform(-8, 2));
  return values;
}

TEST(Statistics, AgreeWithTheirDefinitions) {
  for (const std::size_t n : {1u, 2u, 3u, 19u, 100u, 101u, 5000u, 20001u}) {
    const std::vector<double> values = random_values(n);
    const Statistics s = statistics(values);
    long double sum = 0, squares = 0;
    for (const double v : values) sum += v, squares += static_cast<long double>(v) * v;
    EXPECT_EQ(s.count, n);
    EXPECT_EQ(s.weight, static_cast<double>(n));
    EXPECT_NEAR(s.mean, static_cast<double>(sum / n), 1e-14 * s.mean);
    EXPECT_NEAR(s.rms, static_cast<double>(std::sqrt(squares / n)), 1e-14 * s.rms);
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(s.max, sorted.back());
    EXPECT_EQ(values[s.index_of_max], sorted.back());
    for (const auto& [p, quantile] : {std::pair{0.5, s.median}, {0.95, s.p95}, {0.99, s.p99}}) {
      // No more than the share p lies below the quantile, and more than p at or below it (unless it is the largest).
      const auto below = std::lower_bound(sorted.begin(), sorted.end(), quantile) - sorted.begin();
      const auto at_most = std::upper_bound(sorted.begin(), sorted.end(), quantile) - sorted.begin();
      EXPECT_LE(static_cast<double>(below), p * static_cast<double>(n));
      EXPECT_GT(static_cast<double>(at_most), p * static_cast<double>(n));
    }
  }
}

TEST(Statistics, WeightsAreMultiplicities) {
  Random random(32);
  std::vector<double> values = random_values(3000), weights, repeated;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i % 7 == 0) values[i] = values[0];
    weights.push_back(std::floor(random.uniform(1, 6)));
    for (int k = 0; k < static_cast<int>(weights[i]); ++k) repeated.push_back(values[i]);
  }
  const Statistics weighted = statistics(values, weights), counted = statistics(repeated);
  EXPECT_EQ(weighted.count, values.size());
  EXPECT_EQ(weighted.weight, counted.weight);
  EXPECT_NEAR(weighted.mean, counted.mean, 1e-14 * counted.mean);
  EXPECT_NEAR(weighted.rms, counted.rms, 1e-14 * counted.rms);
  EXPECT_EQ(weighted.median, counted.median);
  EXPECT_EQ(weighted.p95, counted.p95);
  EXPECT_EQ(weighted.p99, counted.p99);
  EXPECT_EQ(weighted.max, counted.max);
}

TEST(Statistics, QuantilesAtAStepAgreeWithAndWithoutWeights) {
  const std::vector<double> values{1, 2}, weights{2, 2}, repeated{1, 1, 2, 2};
  EXPECT_EQ(statistics(repeated).median, 2);
  EXPECT_EQ(statistics(values, weights).median, 2);
}

TEST(Statistics, OfEqualValuesAreThatValue) {
  for (const double v : {0.1, 1e-200, 1e200, 0.0}) {
    const Statistics s = statistics(std::vector<double>(10000, v));
    for (const double x : {s.mean, s.rms, s.median, s.p95, s.p99, s.max}) EXPECT_DOUBLE_EQ(x, v);
    EXPECT_EQ(s.index_of_max, 0u);
  }
}

TEST(Statistics, SameBitsForAnyNumberOfThreads) {
  const std::vector<double> values = random_values(100000);
  RunContext one;
  one.threads = 1;
  const Statistics expected = statistics(values, {}, one);
  for (const int threads : {2, 4}) {
    RunContext context;
    context.threads = threads;
    const Statistics s = statistics(values, {}, context);
    EXPECT_EQ(s.mean, expected.mean);
    EXPECT_EQ(s.rms, expected.rms);
  }
}

TEST(Statistics, OfNothingAreZeroAndOfNonsenseAnError) {
  const Statistics s = statistics({});
  EXPECT_EQ(s.count, 0u);
  for (const double x : {s.weight, s.mean, s.rms, s.median, s.p95, s.p99, s.max}) EXPECT_EQ(x, 0);
  const std::vector<double> values{1, 2}, one_weight{1}, zero_weight{1, 0}, not_finite{1, std::nan("")};
  EXPECT_THROW(statistics(values, one_weight), InvariantError);
  EXPECT_THROW(statistics(values, zero_weight), InvariantError);
  EXPECT_THROW(statistics(not_finite), InvariantError);
}

TEST(Statistics, Scale) {
  const Statistics s = statistics(random_values(100)), twice = scaled(s, 2);
  EXPECT_EQ(twice.rms, 2 * s.rms);
  EXPECT_EQ(twice.p99, 2 * s.p99);
  EXPECT_EQ(twice.weight, s.weight);
  EXPECT_EQ(twice.index_of_max, s.index_of_max);
}

TEST(Histogram, CountsEveryValueOnce) {
  const std::vector<double> values{0, 0.5, 1, 1.5, 2, 7}, weights{1, 2, 3, 4, 5, 6};
  EXPECT_EQ(histogram(values, {1, 2}).counts, (std::vector<double>{2, 2, 2}));
  EXPECT_EQ(histogram(values, {1, 2}, weights).counts, (std::vector<double>{3, 7, 11}));
  const std::vector<double> many = random_values(1000);
  const Histogram h = histogram(many, decade_edges());
  EXPECT_EQ(std::accumulate(h.counts.begin(), h.counts.end(), 0.0), 1000);
  EXPECT_EQ(h.counts.size(), h.edges.size() + 1);
  EXPECT_TRUE(std::is_sorted(h.edges.begin(), h.edges.end()));
}

}  // namespace
}  // namespace gpsrecon::test
