#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/neighbors.h>
#include <span>
#include <vector>

namespace gpsrecon::internal {

/// Finds the components of a mixture that matter at a point. Components are kept by size, in classes whose largest
/// deviations lie within a factor of two, with a search radius for each: with one radius a single wide Gaussian would
/// make every search long. Queries are const and may run in parallel.
class ComponentSearch {
 public:
  /// Copies what it needs; O(n log n).
  explicit ComponentSearch(const Mixture& mixture);

  /// All components within `reach` > 0 deviations (Mahalanobis distance) of x, and some beyond: those whose mean lies
  /// within `reach` times the largest deviation of their class plus `margin` >= 0. By class, in it by ascending index.
  /// `found` is overwritten.
  void within(const Vec3& x, double reach, std::vector<Index>& found, double margin = 0) const;

  /// Largest deviation of the components of the finest class; 0 if there are none.
  double finest_deviation() const { return classes_.empty() ? 0 : classes_.front().largest_deviation; }

 private:
  struct SizeClass {
    std::vector<Index> components;
    double largest_deviation = 0;
    Neighbors means{{}};
  };
  std::vector<SizeClass> classes_;  ///< from fine to coarse
};

}  // namespace gpsrecon::internal
