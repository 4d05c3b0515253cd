#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/scan/scan_target.h>
#include <memory>

namespace gpsrecon::internal {

/// A mesh to be scanned: rays against its triangles, found with CGAL's tree of axis-aligned boxes. Polygons are split
/// into fans from their first corner; faces without area are never hit. The normal of a hit is that of its triangle.
/// Rays are exact up to rounding: one that runs through an edge may miss both of its faces.
class MeshTarget final : public ScanTarget {
 public:
  /// Copies what it needs; O(n log n), about 250 bytes per triangle. Throws InvariantError if a corner is out of range
  /// or a used position is not finite; NoSurfaceError if no face has an area.
  explicit MeshTarget(const Mesh& mesh);
  ~MeshTarget() override;

  std::optional<SurfaceHit> first_hit(const Vec3& origin, const Vec3& direction) const override;
  /// Of the bounding box of the used vertices.
  Vec3 center() const override { return center_; }
  /// Half the diagonal.
  double bounding_radius() const override { return diagonal_ / 2; }
  double diagonal() const override { return diagonal_; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  Vec3 center_;
  double diagonal_;
};

}  // namespace gpsrecon::internal
