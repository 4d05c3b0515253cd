#pragma once

#include <gpsrecon/gps/scheme_rows.h>

namespace gpsrecon::internal {

/// One refinement step of any scheme: the new faces, and the new vertices as combinations of the old ones.
struct Refinement {
  FaceList faces;
  StencilTable stencils;
};

/// Weight β of each of the n neighbours of an interior vertex; the vertex itself keeps 1 - nβ. Precondition: n >= 1.
double loop_beta(LoopWeights weights, Index n);

/// The rows of one Loop step, numbered as the vertices of refine_triangles(connectivity): old vertices first, then one
/// vertex per edge. Interior: 1 - nβ and β; 3/8, 3/8, 1/8, 1/8 on edges (Loop 1987). Boundary: the cubic B-spline
/// curve, 3/4, 1/8, 1/8 and 1/2, 1/2; with CornerRule::sharp, vertices of a single face are kept. Vertices without
/// faces are kept. All weights are positive and sum to one. A source of rows; the connectivity must outlive it.
class LoopRows : public StepRows {
 public:
  LoopRows(const Connectivity& connectivity, LoopWeights weights, CornerRule corners);

  std::size_t columns() const { return connectivity_.vertex_count; }
  void fill(std::size_t r, std::span<Index> row) const;
};

/// The same, stored. O(n).
StencilTable loop_stencils(const Connectivity& connectivity, LoopWeights weights, CornerRule corners,
                           const RunContext& context = {});

/// Limit positions and tangents of the Loop surface at the vertices of a mesh, for the rules of LoopRows.
/// With n neighbours r_0 .. in counter-clockwise order, k faces and θ = π/k:
///   interior   position 1 - nω and ω = 1/(n + 3/(8β)); tangents cos(2πj/n), sin(2πj/n);
///   boundary   position 2/3, 1/6, 1/6 (cubic B-spline); tangent r_0 - r_k along the boundary, and across it the left
///              eigenvector of the k-face fan: for k >= 2 with eigenvalue 3/8 + cos θ/4, for k = 1 with 1/4;
///   corner     kept; tangents along its two edges.
/// Tangents have arbitrary length. On the boundary from k = 6 on Loop's rules leave no tangent plane (a second inner
/// mode shrinks no faster than the boundary): the two tangents given are then those of the boundary curve and of the
/// dominant mode, which the normals of the neighbours on the boundary tend to. At an interior vertex of two faces the
/// second one vanishes: there is no tangent plane to find from a one-ring. Vertices without faces have zero tangents.
/// A source of rows; the connectivity must outlive it.
class LoopLimitRows : public LimitRows {
 public:
  /// With `refined`, the rows are those of the vertices of refine_triangles(connectivity).
  LoopLimitRows(const Connectivity& connectivity, LoopWeights weights, CornerRule corners, bool refined);

  std::size_t columns() const { return rows(); }
  std::size_t rows() const { return connectivity_.vertex_count + (refined_ ? connectivity_.edge_count() : 0); }
  Mask mask(std::size_t r) const;
  void fill(std::size_t r, std::span<Index> row) const;
};

/// The rows of the vertices of the mesh itself, stored. O(n).
LimitTable limit_table(const Connectivity& connectivity, LoopWeights weights, CornerRule corners,
                       const RunContext& context = {});

/// One Loop step on a face list. Throws InvariantError as triangle_connectivity. O(n); chains of steps
/// are faster on Connectivity.
Refinement loop_refine(const FaceList& faces, std::size_t vertex_count, LoopWeights weights = LoopWeights::loop,
                       CornerRule corners = CornerRule::smooth, const RunContext& context = {});

}  // namespace gpsrecon::internal
