#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/gps/stencils.h>
#include <gpsrecon/gps/subdivide.h>

// Internal to lib/gps: what the rows of both schemes have in common. On the boundary the surface is the cubic B-spline
// of the boundary vertices, and what no face uses, and a sharp corner, stays where it is.

namespace gpsrecon::internal {

/// Which rule a vertex follows, at every level alike.
enum class VertexRule {
  unused,    ///< no face uses it: kept
  corner,    ///< sharp corner: kept
  boundary,  ///< on the boundary curve
  interior,
};
inline VertexRule vertex_rule(const Connectivity& connectivity, Index v, CornerRule corners) {
  if (connectivity.unused(v)) return VertexRule::unused;
  if (!connectivity.on_boundary(v)) return VertexRule::interior;
  return corners == CornerRule::sharp && connectivity.face_count[v] == 1 ? VertexRule::corner : VertexRule::boundary;
}

/// Rows of the new vertices of one step that replace old vertices, then of those of edges.
class StepRows {
 public:
  using Weight = double;

  std::size_t rows() const { return connectivity_.vertex_count + connectivity_.edge_count(); }
  const MaskStore<double>& masks() const { return masks_; }
  Mask mask(std::size_t r) const {
    if (r >= connectivity_.vertex_count) return on_boundary_edge(r) ? boundary_edge_ : interior_edge_;
    const auto v = static_cast<Index>(r);
    switch (vertex_rule(connectivity_, v, corners_)) {
      case VertexRule::boundary:
        return boundary_vertex_;
      case VertexRule::interior:
        return interior_vertex_[connectivity_.face_count[v]];
      default:
        return kept_;
    }
  }

 protected:
  /// interior_vertex(n): the mask of a vertex of n >= 1 faces.
  StepRows(const Connectivity& connectivity, CornerRule corners, std::span<const double> interior_edge,
           const auto& interior_vertex)
      : connectivity_(connectivity),
        corners_(corners),
        masks_(),  // not left out: clang then warns, as this is a template
        kept_(masks_.add(std::array{1.0})),
        boundary_vertex_(masks_.add(std::array{3.0 / 4, 1.0 / 8, 1.0 / 8})),
        boundary_edge_(masks_.add(std::array{1.0 / 2, 1.0 / 2})),
        interior_edge_(masks_.add(interior_edge)),
        interior_vertex_(masks_.add_by_count(connectivity.face_count,
                                             [&](Index n) { return interior_vertex(std::max<Index>(n, 1)); })) {}

  /// Half-edge of the edge of row r.
  Index half_edge(std::size_t r) const { return connectivity_.edge_start[r - connectivity_.vertex_count]; }
  /// Fills the row of what is kept or on the boundary; of what is inside only the old vertex, or the ends of the edge,
  /// and returns true.
  bool interior_after_fill(std::size_t r, std::span<Index> row) const {
    if (r >= connectivity_.vertex_count) {
      row[0] = connectivity_.source(half_edge(r));
      row[1] = connectivity_.target(half_edge(r));
      return row.size() > 2;
    }
    const auto v = static_cast<Index>(r);
    row[0] = v;
    if (row.size() == 1) return false;
    if (!connectivity_.on_boundary(v)) return true;
    row[1] = connectivity_.target(connectivity_.vertex_start[v]);
    row[2] = connectivity_.source(connectivity_.for_each_leaving(v, [](Index) {}));
    return false;
  }

  const Connectivity& connectivity_;

 private:
  bool on_boundary_edge(std::size_t r) const { return connectivity_.opposite[half_edge(r)] == no_index; }

  CornerRule corners_;
  MaskStore<double> masks_;
  Mask kept_, boundary_vertex_, boundary_edge_, interior_edge_;
  std::vector<Mask> interior_vertex_;  ///< by number of faces
};

/// Rows of the limits at the vertices of a mesh; if `refined`, at those of one refinement, which need not be made for
/// it: those that replace old vertices, then those of edges, which are regular, then those of faces if the scheme has
/// some.
class LimitRows {
 public:
  using Weight = LimitWeight;

  const MaskStore<LimitWeight>& masks() const { return masks_; }

 protected:
  /// boundary(n), interior(n): the masks of a vertex of n >= 1 faces. `counts`: the numbers of faces in the interior.
  LimitRows(const Connectivity& connectivity, CornerRule corners, bool refined, Index regular_valence,
            const auto& boundary, const auto& interior, std::span<const Index> counts)
      : connectivity_(connectivity),
        refined_(refined),
        corners_(corners),
        masks_(),  // not left out: clang then warns, as this is a template
        unused_(masks_.add(std::array{LimitWeight{1, 0, 0}})),
        // The corner and the ends of its two edges, along which the tangents run.
        corner_(masks_.add(std::array{LimitWeight{1, -1, -1}, LimitWeight{0, 1, 0}, LimitWeight{0, 0, 1}})),
        regular_boundary_(masks_.add(boundary(regular_valence / 2))),
        regular_interior_(masks_.add(interior(regular_valence))),
        boundary_(
            masks_.add_by_count(connectivity.face_count, [&](Index n) { return boundary(std::max<Index>(n, 1)); })),
        interior_(masks_.add_by_count(counts, [&](Index n) { return interior(std::max<Index>(n, 1)); })) {}

  Mask vertex_mask(Index v) const {
    switch (vertex_rule(connectivity_, v, corners_)) {
      case VertexRule::unused:
        return unused_;
      case VertexRule::corner:
        return corner_;
      case VertexRule::boundary:
        return boundary_[connectivity_.face_count[v]];
      default:
        return interior_[connectivity_.face_count[v]];
    }
  }
  Mask edge_mask(std::size_t edge) const {
    return connectivity_.opposite[connectivity_.edge_start[edge]] == no_index ? regular_boundary_ : regular_interior_;
  }
  Mask interior_mask(Index n) const { return interior_[n]; }

  const Connectivity& connectivity_;
  bool refined_;

 private:
  CornerRule corners_;
  MaskStore<LimitWeight> masks_;
  Mask unused_, corner_, regular_boundary_, regular_interior_;
  std::vector<Mask> boundary_, interior_;  ///< by number of faces
};

}  // namespace gpsrecon::internal
