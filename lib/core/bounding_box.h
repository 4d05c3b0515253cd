#pragma once

#include <gpsrecon/core/vec.h>
#include <Eigen/Geometry>
#include <span>

namespace gpsrecon::internal {

/// An axis-aligned box; one that holds nothing is empty, isEmpty().
using Box3 = Eigen::AlignedBox3d;

/// The smallest box that holds all points, in their units. O(n).
inline Box3 bounding_box(std::span<const Vec3> points) {
  Box3 box;
  for (const Vec3& p : points) box.extend(p);
  return box;
}

/// The same of the points with these indices, repeated ones included.
inline Box3 bounding_box(std::span<const Vec3> points, std::span<const Index> used) {
  Box3 box;
  for (const Index i : used) box.extend(points[i]);
  return box;
}

/// Length of the diagonal, in the units of the points; 0 of an empty box.
inline double diagonal_length(const Box3& box) {
  return box.isEmpty() ? 0 : box.diagonal().norm();
}
inline double bounding_box_diagonal(std::span<const Vec3> points) {
  return diagonal_length(bounding_box(points));
}

}  // namespace gpsrecon::internal
