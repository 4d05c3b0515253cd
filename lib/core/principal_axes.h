#pragma once

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/sym3.h>
#include <span>

namespace gpsrecon::internal {

/// Covariance of the points `near`, one of which is at `center`, around their mean: Σ (p - p̄)(p - p̄)ᵀ / n. Its
/// eigenvectors are the principal axes, the first the normal of the plane of least squares (Hoppe et al. 1992).
/// Sums are of differences from `center`, so that a position far from the origin costs no digits. Precondition: not
/// empty.
Sym3 local_covariance(std::span<const Vec3> points, const Vec3& center, std::span<const Neighbor> near);

/// Σ (p - p̄)(p - p̄)ᵀ over all points. O(n).
Sym3 scatter(std::span<const Vec3> points);

/// Whether all points lie on one line, or nearly: none is farther from it than 1e-9 of their extent along it. O(n).
bool on_a_line(std::span<const Vec3> points);

}  // namespace gpsrecon::internal
