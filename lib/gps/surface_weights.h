#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/core/surface_rules.h>
#include <cstdint>
#include <span>
#include <vector>

namespace gpsrecon {

/// A point of a limit surface. Scheme::loop: patch f is face f with corners a, b, c, and (u, v) stands for the
/// barycentric coordinates 1 - u - v, u, v; u, v >= 0, u + v <= 1. Scheme::catmull_clark: patch first_patch(f) is face
/// f with corners a, b, c, d at (0,0), (1,0), (1,1), (0,1), if it has four corners; a face of n != 4 corners has n
/// patches from first_patch(f) on, one for each corner: the corner at (0,0), the middle of the edge that leaves it at
/// (1,0), of the edge that arrives at (0,1), and the middle of the face at (1,1). 0 <= u, v <= 1.
struct SurfaceParameter {
  Index patch = 0;
  double u = 0, v = 0;
};

/// At an irregular vertex derivatives by the parameters vanish or diverge. They are then those at this distance from it
/// in u and v: in parameters of a quadrilateral or triangle of the control mesh; of a patch of other faces it is twice
/// that.
inline constexpr double extraordinary_offset = 1.0 / 16;

/// One row of a sparse linear map. A column may occur twice.
template <class Weight>
struct Row {
  std::span<const Index> indices;
  std::span<const Weight> weights;
};

/// A sparse linear map from old vertices (columns) to new ones (rows). Row r has the columns
/// indices[offsets[r] .. offsets[r + 1]) with as many weights from weights[masks[r]] on: rows of one kind share their
/// weights, because a subdivision scheme has only one mask per valence.
template <class W>
struct Stencils {
  using Weight = W;
  std::size_t columns = 0;
  std::vector<std::uint32_t> offsets{0};
  std::vector<Index> indices;
  std::vector<std::uint32_t> masks;
  std::vector<Weight> weights;

  std::size_t rows() const { return masks.size(); }
  Row<Weight> row(std::size_t r) const {
    const std::size_t begin = offsets[r], length = offsets[r + 1] - begin;
    return {{indices.data() + begin, length}, {weights.data() + masks[r], length}};
  }
};

/// The weight of a control vertex in the linear limit surface at a parameter, and in its derivatives by (u, v): the
/// basis function of the vertex there.
struct JetWeight {
  double value, u, v, uu, uv, vv;
};
/// One row per parameter.
using JetTable = Stencils<JetWeight>;

/// The basis functions of the subdivision surface over a control mesh, and their derivatives, at each parameter, from
/// connectivity alone: Σ_j weight_j value_j over row r is the linear limit surface of any values at the control
/// vertices (numbers, colours, dual points), or its derivative. The indices of a row ascend, each occurs once. Σ value
/// = 1, and Σ = 0 of every derivative, and values are not negative, all to rounding. `control` is manifold and
/// consistently oriented, with Scheme::loop of triangles. In parallel. Throws OptionError for parameters outside their
/// patches; InvariantError; Cancelled. O(n) for the control mesh and O(1) for each parameter, but O(n d) in a face with
/// a vertex of n faces at a parameter distance of 2^-d. SurfaceEvaluator::weights() does the first once.
JetTable surface_weights(const Connectivity& control, const SurfaceRules& rules,
                         std::span<const SurfaceParameter> parameters, const RunContext& context = {});

}  // namespace gpsrecon
