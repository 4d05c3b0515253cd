#pragma once

#include <gpsrecon/gps/loop.h>

namespace gpsrecon {

/// Limit positions and tangents of the Loop surface at the vertices of a mesh, for the same rules as loop_stencils.
/// With n neighbours r_0 .. in counter-clockwise order, k faces and θ = π/k:
///   interior   position 1 - nω and ω = 1/(n + 3/(8β)); tangents cos(2πj/n), sin(2πj/n);
///   boundary   position 2/3, 1/6, 1/6 (cubic B-spline); tangent r_0 - r_k along the boundary, and across it the left
///              eigenvector of the k-face fan: for k >= 2 with eigenvalue 3/8 + cos θ/4, for k = 1 with 1/4;
///   corner     kept; tangents along its two edges.
/// Tangents have arbitrary length. On the boundary from k = 6 on Loop's rules leave no tangent plane (a second inner
/// mode shrinks no faster than the boundary): the two tangents given are then those of the boundary curve and of the
/// dominant mode, which the normals of the neighbours on the boundary tend to. At an interior vertex of two faces the
/// second one vanishes: there is no tangent plane to find from a one-ring. Vertices without faces have zero tangents.
/// O(n).
LimitTable limit_table(const TriangleConnectivity& connectivity, LoopWeights weights, CornerRule corners,
                       const RunContext& context = {});

}  // namespace gpsrecon
