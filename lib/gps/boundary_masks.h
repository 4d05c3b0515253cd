#pragma once

#include <gpsrecon/gps/stencils.h>
#include <array>

// Internal to lib/gps: masks that both schemes have. On the boundary the surface is the cubic B-spline of the boundary
// vertices, and what no face uses, and a sharp corner, stays where it is.

namespace gpsrecon::internal {

inline constexpr std::array kept_mask{1.0};
inline constexpr std::array boundary_vertex_mask{3.0 / 4, 1.0 / 8, 1.0 / 8};
inline constexpr std::array boundary_edge_mask{1.0 / 2, 1.0 / 2};

inline constexpr std::array unused_limit_mask{LimitWeight{1, 0, 0}};
/// Of the corner and of the ends of its two edges, along which the tangents run.
inline constexpr std::array corner_limit_mask{LimitWeight{1, -1, -1}, LimitWeight{0, 1, 0}, LimitWeight{0, 0, 1}};

}  // namespace gpsrecon::internal
