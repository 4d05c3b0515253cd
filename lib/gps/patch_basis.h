#pragma once

#include <Eigen/Core>
#include <array>
#include <type_traits>

// Internal to lib/gps: the polynomials of regular patches.

namespace gpsrecon::internal {

/// A weight in the value of a surface at a parameter; with Order 2, also in its derivatives: 1, s, t, ss, st, tt.
template <int Order>
using BasisWeight = std::conditional_t<Order == 0, double, Eigen::Matrix<double, 6, 1>>;

/// The points of a lattice that a basis function belongs to.
struct LatticePoint {
  int x, y;
};

/// The control points of the triangle (0,0), (1,0), (0,1) of a regular triangulation, whose vertices have the
/// neighbours (±1,0), (0,±1), (1,-1), (-1,1).
inline constexpr std::array<LatticePoint, 12> triangle_patch{
    {{0, 0}, {1, 0}, {0, 1}, {1, -1}, {1, 1}, {-1, 1}, {0, -1}, {-1, 0}, {2, -1}, {2, 0}, {0, 2}, {-1, 2}}};

/// The quartic box spline basis at (s, t), in the order of triangle_patch. Order: 0 or 2.
template <int Order>
std::array<BasisWeight<Order>, 12> box_spline_basis(double s, double t);

/// The uniform bicubic B-spline basis at (s, t) of the square [0, 1]²; function 4 (y + 1) + x + 1 belongs to the point
/// (x, y), -1 <= x, y <= 2. Order: 0 or 2.
template <int Order>
std::array<BasisWeight<Order>, 16> bicubic_basis(double s, double t);

}  // namespace gpsrecon::internal
