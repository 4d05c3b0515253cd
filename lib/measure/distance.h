#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <memory>
#include <span>
#include <vector>

namespace gpsrecon {

/// The point of a surface nearest to a query.
struct ClosestPoint {
  double distance = 0;        ///< Euclidean, not squared, >= 0
  Vec3 point = Vec3::Zero();  ///< on the surface, up to rounding
  Index face = no_index;      ///< face of the mesh; which of equally near ones depends on the queries before
};

/// Exact distance to the faces of a mesh, up to rounding, in the units of its positions: CGAL's tree of axis-aligned
/// boxes over triangles. Polygons are split into fans from their first corner. Faces without area (repeated corners,
/// collinear ones) count as the segments or points they are. About 80 bytes per triangle and 24 per vertex.
class SurfaceDistance {
 public:
  /// Copies what it needs; O(n log n). Throws InvariantError if a corner is out of range or a used position is not
  /// finite; Cancelled. A mesh without faces is allowed.
  explicit SurfaceDistance(const Mesh& mesh, const RunContext& context = {});
  ~SurfaceDistance();
  SurfaceDistance(SurfaceDistance&&) noexcept;
  SurfaceDistance& operator=(SurfaceDistance&&) noexcept;

  bool empty() const { return triangle_count() == 0; }
  std::size_t triangle_count() const;

  /// For single points: without the first guess that distances() has for nearly all, a query near a large surface takes
  /// up to a hundred times as long. Precondition: not empty; query finite and within 1e70 times the size of the
  /// surface.
  ClosestPoint closest(const Vec3& query) const;

  /// One result per point, in the order of the points; the same bytes for any number of threads. Points may be given in
  /// any order (they are visited along a space-filling curve, each starting from the footpoint of the one before).
  /// Throws InvariantError if the surface is empty or a point is not finite, or farther than 1e70 times the size of the
  /// surface; Cancelled.
  std::vector<ClosestPoint> distances(std::span<const Vec3> points, const RunContext& context = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gpsrecon
