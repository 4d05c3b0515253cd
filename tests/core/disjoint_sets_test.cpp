#include <gpsrecon/core/disjoint_sets.h>

#include <gtest/gtest.h>
#include <vector>

#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

TEST(DisjointSets, KeepSignsThroughAnyOrderOfJoins) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Random random(seed);
    constexpr std::size_t n = 60;
    std::vector<int> sign(n);
    for (int& s : sign) s = random.uniform() < 0.5 ? 1 : -1;
    DisjointSets sets(n);
    for (int k = 0; k < 300; ++k) {
      const auto a = static_cast<Index>(random.below(n)), b = static_cast<Index>(random.below(n));
      sets.join(a, b, sign[a] * sign[b]);
      const DisjointSets::Root ra = sets.root(a), rb = sets.root(b);
      EXPECT_EQ(ra.index, rb.index);
      EXPECT_EQ(ra.sign * rb.sign, sign[a] * sign[b]);
    }
  }
}

/// The second implementation: a label per member, rewritten at every join.
TEST(DisjointSets, AreThoseOfRelabelling) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Random random(seed);
    constexpr Index n = 80;
    std::vector<Index> label(n);
    std::iota(label.begin(), label.end(), Index{0});
    DisjointSets sets(n);
    for (int k = 0; k < 70; ++k) {
      const auto a = static_cast<Index>(random.below(n)), b = static_cast<Index>(random.below(n));
      const Index from = label[b], to = label[a];
      EXPECT_EQ(sets.join(a, b), from != to);
      for (Index& l : label)
        if (l == from) l = to;
    }
    for (Index i = 0; i < n; ++i) {
      EXPECT_EQ(label[sets.find(i)], label[i]) << "the root is a member";
      for (Index j = 0; j < n; ++j) EXPECT_EQ(sets.find(i) == sets.find(j), label[i] == label[j]);
    }
  }
}

TEST(DisjointSets, KeepTheRootOfTheLargerSetOrOfTheFirst) {
  DisjointSets sets(5);
  EXPECT_TRUE(sets.join(3, 1));
  EXPECT_EQ(sets.find(1), 3U);
  EXPECT_TRUE(sets.join(0, 1, -1));
  EXPECT_EQ(sets.find(0), 3U);
  EXPECT_EQ(sets.root(0).sign, -1);
  EXPECT_FALSE(sets.join(0, 3, 1)) << "what is joined keeps its sign";
  EXPECT_EQ(sets.root(0).sign, -1);
  EXPECT_EQ(sets.find(4), 4U);
}

}  // namespace
}  // namespace gpsrecon
