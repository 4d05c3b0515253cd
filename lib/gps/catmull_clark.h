#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/gps/connectivity.h>
#include <gpsrecon/gps/stencils.h>
#include <gpsrecon/gps/subdivide.h>

// Internal to lib/gps: Catmull and Clark's scheme on half-edges, the counterpart of triangle_connectivity, loop and
// limit.

namespace gpsrecon {

/// Half-edges of a polygon mesh; those of a face are consecutive.
struct PolygonConnectivity : Connectivity {
  std::vector<Index> faces;         ///< per half-edge: its face; empty if all have four corners
  std::vector<Index> face_offsets;  ///< per face: its first half-edge, and the end; empty likewise

  bool quads() const { return faces.empty(); }
  std::size_t face_total() const { return quads() ? corners.size() / 4 : face_offsets.size() - 1; }
  Index face(Index h) const { return quads() ? h / 4 : faces[h]; }
  Index face_start(Index f) const { return quads() ? 4 * f : face_offsets[f]; }
  Index face_size(Index f) const { return face_start(f + 1) - face_start(f); }
  Index next(Index h) const {
    if (quads()) return h % 4 == 3 ? h - 3 : h + 1;
    return h + 1 == face_offsets[faces[h] + 1] ? face_offsets[faces[h]] : h + 1;
  }
  Index previous(Index h) const {
    if (quads()) return h % 4 == 0 ? h + 3 : h - 1;
    return h == face_offsets[faces[h]] ? face_offsets[faces[h] + 1] - 1 : h - 1;
  }
  Index target(Index h) const { return corners[next(h)]; }

  /// Calls visit(h) for the half-edges leaving v, counter-clockwise; returns the one that arrives last on a boundary,
  /// otherwise no_index. Precondition: a face uses v.
  template <class Visit>
  Index for_each_leaving(Index v, const Visit& visit) const {
    Index h = vertex_start[v];
    do {
      visit(h);
      const Index arriving = previous(h);
      h = opposite[arriving];
      if (h == no_index) return arriving;
    } while (h != vertex_start[v]);
    return no_index;
  }
};

/// Throws InvariantError as connectivity. O(c log c) in the number of corners.
PolygonConnectivity polygon_connectivity(const FaceList& faces, std::size_t vertex_count);

/// One quadrilateral per corner: half-edge h becomes quadrilateral h, (its source, its edge, its face, the edge
/// before). Vertices are the old ones, one per edge, one per face. O(n).
PolygonConnectivity refine(const PolygonConnectivity& parent, const RunContext& context = {});

/// The faces of refine(parent) alone. O(n).
FaceList refined_faces(const PolygonConnectivity& parent, const RunContext& context = {});

/// Rows of the points of the faces, the means of their corners: the first half of a step.
class CatmullClarkFaceRows {
 public:
  using Weight = double;
  explicit CatmullClarkFaceRows(const PolygonConnectivity& connectivity);

  std::size_t columns() const { return connectivity_.vertex_count; }
  std::size_t rows() const { return connectivity_.face_total(); }
  const MaskStore<double>& masks() const { return masks_; }
  Mask mask(std::size_t r) const { return by_size_[connectivity_.face_size(static_cast<Index>(r))]; }
  void fill(std::size_t r, std::span<Index> row) const;

 private:
  const PolygonConnectivity& connectivity_;
  MaskStore<double> masks_;
  std::vector<Mask> by_size_;
};

/// Rows of the new vertices but the points of the faces, numbered as those of refine(connectivity), in terms of the old
/// vertices followed by the points of the faces: v' = (F + 2R + (n - 3) v) / n with the means F of the face points and
/// R of the middles of the n edges, that is v (n - 2)/n and 1/n² of the other ends and the face points; 1/4 on edges.
/// Boundary: the cubic B-spline curve; with CornerRule::sharp, vertices of a single face are kept. Vertices without
/// faces are kept (Catmull and Clark 1978). The connectivity must outlive the rows.
class CatmullClarkRows {
 public:
  using Weight = double;
  CatmullClarkRows(const PolygonConnectivity& connectivity, CornerRule corners);

  std::size_t columns() const { return connectivity_.vertex_count + connectivity_.face_total(); }
  std::size_t rows() const { return connectivity_.vertex_count + connectivity_.edge_count(); }
  const MaskStore<double>& masks() const { return masks_; }
  Mask mask(std::size_t r) const;
  void fill(std::size_t r, std::span<Index> row) const;

 private:
  const PolygonConnectivity& connectivity_;
  CornerRule corners_;
  MaskStore<double> masks_;
  Mask kept_, boundary_vertex_, boundary_edge_, interior_edge_;
  std::vector<Mask> interior_vertex_;  ///< by valence
};

/// Limit positions and tangents at the vertices of a mesh of quadrilaterals: in the interior n/(n + 5), 4/(n(n + 5)),
/// 1/(n(n + 5)) and the dominant left eigenvectors of the fan; on the boundary the cubic B-spline, the tangent along it
/// and the dominant mode across. The connectivity must outlive the rows.
class CatmullClarkLimitRows {
 public:
  using Weight = LimitWeight;
  /// With `refined`, the rows are those of the vertices of refine(connectivity), which need not be made for it.
  /// Otherwise all faces must have four corners.
  CatmullClarkLimitRows(const PolygonConnectivity& connectivity, CornerRule corners, bool refined);

  std::size_t columns() const { return rows(); }
  std::size_t rows() const;
  const MaskStore<LimitWeight>& masks() const { return masks_; }
  Mask mask(std::size_t r) const;
  void fill(std::size_t r, std::span<Index> row) const;

 private:
  const PolygonConnectivity& connectivity_;
  CornerRule corners_;
  bool refined_;
  MaskStore<LimitWeight> masks_;
  Mask unused_, corner_, regular_boundary_, regular_interior_;
  std::vector<Mask> boundary_, interior_;  ///< by number of faces
};

}  // namespace gpsrecon
