#pragma once

#include <gpsrecon/gps/scheme_rows.h>

// Internal to lib/gps: Catmull and Clark's scheme on half-edges, the counterpart of loop.

namespace gpsrecon::internal {

/// Rows of the points of the faces, the means of their corners: the first half of a step.
class CatmullClarkFaceRows {
 public:
  using Weight = double;
  explicit CatmullClarkFaceRows(const Connectivity& connectivity);

  std::size_t columns() const { return connectivity_.vertex_count; }
  std::size_t rows() const { return connectivity_.face_total(); }
  const MaskStore<double>& masks() const { return masks_; }
  Mask mask(std::size_t r) const { return by_size_[connectivity_.face_size(static_cast<Index>(r))]; }
  void fill(std::size_t r, std::span<Index> row) const;

 private:
  const Connectivity& connectivity_;
  MaskStore<double> masks_;
  std::vector<Mask> by_size_;
};

/// Rows of the new vertices but the points of the faces, numbered as those of refine_to_quads(connectivity), in terms
/// of the old vertices followed by the points of the faces: v' = (F + 2R + (n - 3) v) / n with the means F of the face
/// points and R of the middles of the n edges, that is v (n - 2)/n and 1/n² of the other ends and the face points; 1/4
/// on edges. Boundary: the cubic B-spline curve; with CornerRule::sharp, vertices of a single face are kept. Vertices
/// without faces are kept (Catmull and Clark 1978). The connectivity must outlive the rows.
class CatmullClarkRows : public StepRows {
 public:
  CatmullClarkRows(const Connectivity& connectivity, CornerRule corners);

  std::size_t columns() const { return connectivity_.vertex_count + connectivity_.face_total(); }
  void fill(std::size_t r, std::span<Index> row) const;
};

/// Limit positions and tangents at the vertices of a mesh of quadrilaterals: in the interior n/(n + 5), 4/(n(n + 5)),
/// 1/(n(n + 5)) and the dominant left eigenvectors of the fan; on the boundary the cubic B-spline, the tangent along it
/// and the dominant mode across. The connectivity must outlive the rows.
class CatmullClarkLimitRows : public LimitRows {
 public:
  /// With `refined`, the rows are those of the vertices of refine_to_quads(connectivity). Otherwise all faces must have
  /// four corners.
  CatmullClarkLimitRows(const Connectivity& connectivity, CornerRule corners, bool refined);

  std::size_t columns() const { return rows(); }
  std::size_t rows() const;
  Mask mask(std::size_t r) const;
  void fill(std::size_t r, std::span<Index> row) const;
};

}  // namespace gpsrecon::internal
