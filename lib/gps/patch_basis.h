#pragma once

#include <array>
#include <cstddef>

// Internal to lib/gps: the polynomials of regular patches.

namespace gpsrecon {

/// Values, first and second derivatives of the basis functions of a patch: rows 1, s, t, ss, st, tt.
template <std::size_t Count>
using BasisJet = std::array<std::array<double, Count>, 6>;

/// The points of a lattice that a basis function belongs to.
struct LatticePoint {
  int x, y;
};

/// The control points of the triangle (0,0), (1,0), (0,1) of a regular triangulation, whose vertices have the
/// neighbours (±1,0), (0,±1), (1,-1), (-1,1).
inline constexpr std::array<LatticePoint, 12> triangle_patch{
    {{0, 0}, {1, 0}, {0, 1}, {1, -1}, {1, 1}, {-1, 1}, {0, -1}, {-1, 0}, {2, -1}, {2, 0}, {0, 2}, {-1, 2}}};

/// The quartic box spline basis at (s, t), in the order of triangle_patch. The first `order` derivatives are computed.
BasisJet<12> box_spline_basis(double s, double t, int order = 2);

/// The uniform bicubic B-spline basis at (s, t) of the square [0, 1]²; function 4 (y + 1) + x + 1 belongs to the point
/// (x, y), -1 <= x, y <= 2.
BasisJet<16> bicubic_basis(double s, double t, int order = 2);

}  // namespace gpsrecon
