// The counter-based random numbers, with fixed seeds: these tests cannot fail by chance, only by a change.

#include <gpsrecon/core/random.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <set>
#include <vector>

namespace gpsrecon::test {

using namespace internal;
namespace {

/// Pearson's statistic of counts that should be equal.
double chi_square(const std::vector<double>& counts) {
  double total = 0;
  for (const double c : counts) total += c;
  const double expected = total / static_cast<double>(counts.size());
  double sum = 0;
  for (const double c : counts) sum += (c - expected) * (c - expected) / expected;
  return sum;
}

/// Five standard deviations around the mean of the chi-square distribution.
void expect_uniform(const std::vector<double>& counts) {
  const double freedom = static_cast<double>(counts.size()) - 1;
  EXPECT_NEAR(chi_square(counts), freedom, 5 * std::sqrt(2 * freedom));
}

TEST(Random, IsUniformAlongCountersStreamsAndSeeds) {
  constexpr std::size_t bins = 100, n = 100'000;
  for (int which = 0; which < 3; ++which) {
    std::vector<double> counts(bins, 0);
    for (std::uint64_t i = 0; i < n; ++i) {
      const double u = which == 0   ? random_uniform(1, 2, i)
                       : which == 1 ? random_uniform(1, i, 2)
                                    : random_uniform(i, 1, 2);
      ASSERT_GE(u, 0);
      ASSERT_LT(u, 1);
      ++counts[static_cast<std::size_t>(u * bins)];
    }
    expect_uniform(counts);
  }
}

TEST(Random, PairsAreIndependent) {
  constexpr std::size_t bins = 16, n = 100'000;
  // Neighbouring counters, streams and seeds.
  for (int which = 0; which < 3; ++which) {
    std::vector<double> counts(bins * bins, 0);
    for (std::uint64_t i = 0; i < n; ++i) {
      const double a = random_uniform(7, 3, i);
      const double b = which == 0   ? random_uniform(7, 3, i + 1)
                       : which == 1 ? random_uniform(7, 4, i)
                                    : random_uniform(8, 3, i);
      ++counts[static_cast<std::size_t>(a * bins) * bins + static_cast<std::size_t>(b * bins)];
    }
    expect_uniform(counts);
  }
}

TEST(Random, EveryBitIsFair) {
  std::array<int, 64> ones{};
  constexpr int n = 40'000;
  for (std::uint64_t i = 0; i < n; ++i) {
    const std::uint64_t bits = random_bits(5, 0, i);
    for (std::size_t b = 0; b < 64; ++b) ones[b] += static_cast<int>(bits >> b & 1);
  }
  for (const int count : ones) EXPECT_NEAR(count, n / 2.0, 5 * std::sqrt(n / 4.0));
}

TEST(Random, OneChangedInputBitChangesHalfOfTheOutput) {
  double flipped = 0;
  constexpr int n = 500;
  for (std::uint64_t i = 0; i < n; ++i) {
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    flipped += std::popcount(random_bits(i, 2, 3) ^ random_bits(i ^ bit, 2, 3));
    flipped += std::popcount(random_bits(1, i, 3) ^ random_bits(1, i ^ bit, 3));
    flipped += std::popcount(random_bits(1, 2, i) ^ random_bits(1, 2, i ^ bit));
  }
  EXPECT_NEAR(flipped / (3 * n), 32, 0.6);  // standard deviation 4 / sqrt(1500) = 0.1
}

TEST(Random, IsAFunctionOfItsArgumentsOnly) {
  std::vector<double> forward, backward(1000);
  for (std::uint64_t i = 0; i < 1000; ++i) forward.push_back(random_uniform(3, 4, i));
  for (std::uint64_t i = 1000; i-- > 0;) backward[i] = random_uniform(3, 4, i);
  EXPECT_EQ(forward, backward);
  constexpr std::uint64_t compiled = random_bits(1, 2, 3);
  EXPECT_EQ(random_bits(1, 2, 3), compiled);
  std::set<std::uint64_t> distinct;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (std::uint64_t stream = 0; stream < 20; ++stream)
      for (std::uint64_t counter = 0; counter < 20; ++counter) distinct.insert(random_bits(seed, stream, counter));
  EXPECT_EQ(distinct.size(), 8000u);
}

}  // namespace
}  // namespace gpsrecon::test
