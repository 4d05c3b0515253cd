#include <gpsrecon/core/order_statistics.h>

#include <gtest/gtest.h>
#include <vector>

#include "support/random.h"

namespace gpsrecon {

using namespace internal;
namespace {

TEST(ValueOfRank, IsThatOfTheSortedValues) {
  test::Random random(1);
  for (const std::size_t n : {1, 2, 3, 10, 101}) {
    std::vector<double> values(n);
    for (double& v : values) v = std::floor(10 * random.uniform());  // many are equal
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t rank = 0; rank < n; ++rank) {
      EXPECT_EQ(value_of_rank(values, rank), sorted[rank]);
      EXPECT_TRUE(std::is_permutation(values.begin(), values.end(), sorted.begin()));
    }
  }
}

TEST(Median, OfAnEvenNumberIsTheUpperOfTheMiddle) {
  std::vector<double> odd{5, 1, 9}, even{5, 1, 9, 7}, two{2, 1}, one{4};
  EXPECT_EQ(median(odd), 5);
  EXPECT_EQ(median(even), 7);
  EXPECT_EQ(median(two), 2);
  EXPECT_EQ(median(one), 4);
}

}  // namespace
}  // namespace gpsrecon
