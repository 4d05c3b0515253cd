#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace gpsrecon::internal {

/// The value of this rank, 0 that of the smallest. Reorders the values. Expected O(n). Preconditions: rank < size, no
/// NaN.
inline double value_of_rank(std::span<double> values, std::size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The median; of an even number of values the upper of the two in the middle, so that it is one of them. Reorders the
/// values. Expected O(n). Preconditions: not empty, no NaN.
inline double median(std::span<double> values) {
  return value_of_rank(values, values.size() / 2);
}

}  // namespace gpsrecon::internal
