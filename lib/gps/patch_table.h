#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/core/surface_rules.h>
#include <gpsrecon/gps/patch_basis.h>
#include <gpsrecon/gps/stencils.h>
#include <gpsrecon/gps/surface_weights.h>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gpsrecon::internal {

/// The weights of some points at a parameter. Kept from one to the next for its memory; one per thread.
template <int Order>
struct PatchRow {
  std::vector<Index> indices;
  std::vector<BasisWeight<Order>> weights, refined;

  Row<BasisWeight<Order>> row() const { return {indices, weights}; }
};

/// The basis functions of a subdivision surface, and their first and second derivatives, anywhere: everything about the
/// linear limit surface that depends on connectivity alone. Values at the control vertices, such as dual points in R⁹
/// or colours, are applied outside (stencils.h).
///
/// The control mesh is refined once (twice if there are polygons other than quadrilaterals), so that each face has at
/// most one vertex that is not regular, its first: a leaf. A leaf without one is a polynomial of 12 points, the quartic
/// box spline, or 16, the bicubic B-spline, some of them reflected at the boundary. On the others the parameter lies on
/// a regular face of some deeper refinement of the points around. What Stam (1998, 1999) does with powers of
/// eigenvalues is done with the refinement steps themselves, transposed, on the weights of these points: as many as the
/// parameter is close to the vertex, one on three quarters of the leaf. That works for every valence, and on the
/// boundary, where eigenvectors are missing.
///
/// Exactness: a few units in the last place of the largest weight, for values and first derivatives at any distance
/// from irregular vertices; second derivatives lose one bit for each halving of the distance to one. Derivatives by
/// parameters vanish or diverge at an irregular vertex itself: there the weights of the derivatives are those at a
/// parameter distance of extraordinary_offset in u and v, and extraordinary() is true.
class PatchTable {
 public:
  /// `faces` are manifold and consistently oriented, with Scheme::loop triangles; otherwise throws InvariantError.
  /// About 60 numbers per face, and 10 n for each face at a boundary vertex of n. O(n).
  PatchTable(const FaceList& faces, std::size_t control_count, const SurfaceRules& rules = {},
             const RunContext& context = {});
  /// The same with the connectivity at hand, which is manifold and consistently oriented.
  PatchTable(const Connectivity& control, const SurfaceRules& rules, const RunContext& context = {});

  std::size_t control_count() const { return control_count_; }
  std::size_t patch_count() const { return patch_count_; }
  bool triangular() const { return scheme_ == Scheme::loop; }
  /// Precondition: face is one of the mesh.
  Index first_patch(std::size_t face) const {
    return first_patch_.empty() ? static_cast<Index>(face) : first_patch_[face];
  }
  /// Throws OptionError for parameters outside their patches.
  void check(std::span<const SurfaceParameter> parameters) const;

  /// surface_weights(), of this mesh.
  JetTable weights(std::span<const SurfaceParameter> parameters, const RunContext& context = {}) const;

  // Leaves, as flat arrays -------------------------------------------------------------------------------------------

  /// A face of the refined mesh.
  struct Leaf {
    std::uint32_t kind;    ///< 0: regular
    std::uint32_t points;  ///< first of its own indices
    std::uint32_t ring;    ///< first of the indices of its ring, if it is not regular
  };
  /// What leaves have in common whose first vertex is not regular, by number of faces around it, and on the boundary by
  /// which of these the leaf is. The points of such a leaf are, in this order,
  ///   its own ones: the vertex, and those away from it around the two (Loop) or three neighbours in the leaf;
  ///   the ring: what is around the vertex counter-clockwise, from the leaf on, or from the boundary.
  /// The maps are transposed, row i holding what point i gives, and leave out point 0: its weight is what those of the
  /// others leave of Σ = 1, or of 0 for derivatives. So rounding never adds a constant to a derivative, which would not
  /// fade with the steps as derivatives do.
  struct Kind {
    Index faces = 0;
    bool boundary = false;
    Index own_count = 0, ring_count = 0;
    StencilTable step;                    ///< to the points of the leaf half the size at the vertex
    std::array<StencilTable, 3> patches;  ///< to those of the three regular faces that are the rest, with axes like the
                                          ///< leaf's; of a triangle the last is upside down
    std::vector<double> limit;            ///< weights of the limit position of the vertex

    Index point_count() const { return own_count + ring_count; }
  };
  /// A point beyond the boundary: plus[0] + plus[1] - minus, of which at a corner some are ghosts before it.
  struct Ghost {
    std::array<Index, 2> plus;
    Index minus;
  };

  std::span<const Leaf> leaves() const { return leaves_; }
  std::span<const Index> indices() const { return indices_; }
  std::span<const Kind> kinds() const { return kinds_; }
  /// Points from point_count() - ghosts().size() on.
  std::span<const Ghost> ghosts() const { return ghosts_; }
  std::size_t point_count() const { return to_points_.new_vertices() + ghosts_.size(); }
  /// The 12 or 16 points of a regular leaf, in the order of patch_basis.h, or the own ones of another.
  std::span<const Index> points_of(const Leaf& leaf) const {
    return {indices_.data() + leaf.points, leaf.kind == 0 ? patch_size() : kinds_[leaf.kind].own_count};
  }
  /// Precondition: the leaf is not regular.
  std::span<const Index> ring_of(const Leaf& leaf) const {
    return {indices_.data() + leaf.ring, kinds_[leaf.kind].ring_count};
  }
  std::size_t patch_size() const { return triangular() ? 12 : 16; }

  /// Parameters on a leaf, with ∂(s, t)/∂(u, v).
  struct LeafPoint {
    Index leaf;
    double s, t;
    double s_u, s_v, t_u, t_v;
  };
  /// O(1). Precondition: one that check() accepts.
  LeafPoint locate(const SurfaceParameter& parameter) const;
  /// True if the point is the vertex of a leaf where derivatives by parameters do not exist.
  bool extraordinary(const LeafPoint& point) const {
    return leaves_[point.leaf].kind > 0 && std::max(point.s, point.t) <= closest;
  }
  /// The vertex at (0, 0) of a leaf that is not regular, numbered like the vertices of the base mesh.
  Index vertex_of(Index leaf) const { return indices_[leaves_[leaf].points]; }
  /// The leaves around a vertex of the base mesh that is not regular; none around others.
  std::span<const Index> leaves_around(Index vertex) const {
    return {fan_leaves_.data() + fan_offsets_[vertex], fan_leaves_.data() + fan_offsets_[vertex + 1]};
  }
  /// Weights of limit positions and tangents at the vertices of the base mesh, in values there.
  const LimitTable& base_limit() const { return base_limit_; }

  /// Values at the vertices of the base mesh: the control mesh, or its first refinement.
  template <class T>
  std::vector<T> to_base(std::span<const T> control, const RunContext& context) const {
    return to_base_ ? refine_values<T>(*to_base_, control, context) : std::vector<T>(control.begin(), control.end());
  }
  /// Values at the points of the leaves, from those of the base mesh.
  template <class T>
  std::vector<T> to_points(std::span<const T> base, const RunContext& context) const {
    std::vector<T> points = refine_values<T>(to_points_, base, context, ghosts_.size());
    for (const Ghost& ghost : ghosts_)
      points.push_back(points[ghost.plus[0]] + points[ghost.plus[1]] - points[ghost.minus]);
    return points;
  }
  /// The weights of the points of the leaf, by (u, v). Order 0: of the value; 2: and of all derivatives. No allocation
  /// once the row has its size.
  template <int Order>
  void point_weights(const LeafPoint& point, PatchRow<Order>& row) const;

  /// Where derivatives are taken instead of at an irregular vertex, in s and t.
  static constexpr double leaf_offset = 2 * extraordinary_offset;

 private:
  using Step = RefinementStep<StencilTable, StencilTable>;

  /// Distance in leaf parameters below which a point counts as the irregular vertex itself.
  static constexpr double closest = 0x1p-50;

  template <class Scheme>
  void build(const Connectivity& base, const SurfaceRules& rules, const RunContext& context);
  template <int Order>
  void irregular_weights(const LeafPoint& point, PatchRow<Order>& row) const;

  Scheme scheme_ = Scheme::loop;
  std::size_t control_count_ = 0, patch_count_ = 0;
  std::vector<Index> first_patch_;    ///< empty: one per face
  std::vector<Index> base_of_patch_;  ///< empty: the same
  std::vector<bool> split_patch_;     ///< per patch: four faces of the base mesh from base_of_patch_ on
  std::optional<Step> to_base_;
  Step to_points_;
  LimitTable base_limit_;
  std::vector<Ghost> ghosts_;
  std::vector<Leaf> leaves_;
  std::vector<Index> indices_;
  std::vector<Kind> kinds_{Kind{}};
  std::vector<Index> fan_offsets_, fan_leaves_;
};

}  // namespace gpsrecon::internal
