#pragma once

#include <gpsrecon/core/neighbors.h>
#include <span>
#include <vector>

namespace gpsrecon::internal {

/// Least cosine between a normal and the mean way to the sensors that tells the side a sheet was seen from.
inline constexpr double least_view = 0.15;

/// Drops those of the points `near` that lie in another sheet than the first of them. Two sheets show in the offsets
/// along the normal as two heaps with hardly a point in the middle between them (threshold of Otsu 1979). Returns the
/// distance of the two, 0 if there is one. O(k log k). Precondition: not empty.
double keep_one_sheet(std::span<const Vec3> points, const Vec3& normal, std::vector<Neighbor>& near);

}  // namespace gpsrecon::internal
