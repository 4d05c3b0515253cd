#pragma once

#include <gpsrecon/core/vec.h>
#include <Eigen/Geometry>
#include <span>

namespace gpsrecon::internal {

/// Calls visit(a, b, c) for the triangles of the fan around the first corner of a polygon, which have its orientation.
template <class Visitor>
void for_each_triangle(std::span<const Index> face, Visitor visit) {
  for (std::size_t k = 2; k < face.size(); ++k) visit(face[0], face[k - 1], face[k]);
}

/// The normal of a triangle, counter-clockwise seen from its tip, as long as twice the area: (b - a) × (c - a).
inline Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - a);
}

/// The same of a polygon, plane or not: the sum over its fan, which no choice of the first corner changes but for
/// rounding. Zero for fewer than three corners.
inline Vec3 area_vector(std::span<const Vec3> positions, std::span<const Index> face) {
  Vec3 sum = Vec3::Zero();
  for_each_triangle(face,
                    [&](Index a, Index b, Index c) { sum += area_vector(positions[a], positions[b], positions[c]); });
  return sum;
}

/// The normal of a polygon; zero where it has no area.
inline Vec3 unit_normal(std::span<const Vec3> positions, std::span<const Index> face) {
  return area_vector(positions, face).stableNormalized();
}

}  // namespace gpsrecon::internal
