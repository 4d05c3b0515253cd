#pragma once

#include <gpsrecon/core/vec.h>
#include <numeric>
#include <utility>
#include <vector>

namespace gpsrecon::internal {

/// Disjoint sets of 0 .. n-1, each with a sign relative to the others of its set: a forest joined by size, with paths
/// halved (Tarjan & van Leeuwen 1984). Which member stands for a set follows from the joins alone.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n), size_(n, 1), sign_(n, 1) {
    std::iota(parent_.begin(), parent_.end(), Index{0});
  }

  struct Root {
    Index index;
    int sign;  ///< 1 or -1: of the member relative to the root
  };
  /// The member that stands for the set of i. Amortised O(α(n)).
  Root root(Index i) {
    int sign = 1;
    while (parent_[i] != i) {
      const Index up = parent_[i];
      sign_[i] = static_cast<signed char>(sign_[i] * sign_[up]);
      parent_[i] = parent_[up];
      sign *= sign_[i];
      i = parent_[i];
    }
    return {i, sign};
  }
  Index find(Index i) { return root(i).index; }

  /// Joins the sets of a and b so that these two have this sign, 1 or -1, relative to each other; the root of the
  /// larger set stays, of equal ones that of a. False if they are in one set already, which keeps its signs.
  bool join(Index a, Index b, int sign = 1) {
    Root to = root(a), from = root(b);
    if (to.index == from.index) return false;
    if (size_[to.index] < size_[from.index]) std::swap(to, from);
    parent_[from.index] = to.index;
    sign_[from.index] = static_cast<signed char>(to.sign * from.sign * sign);
    size_[to.index] += size_[from.index];
    return true;
  }

 private:
  std::vector<Index> parent_, size_;
  std::vector<signed char> sign_;  ///< relative to the parent; 1 of a root
};

}  // namespace gpsrecon::internal
