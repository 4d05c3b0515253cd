#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/metrics/distance.h>
#include <gpsrecon/metrics/report.h>

namespace gpsrecon {

struct CompareOptions {
  /// Area-uniform samples on each of two meshes. Range: [1, 1e9].
  std::size_t samples = 400000;
  /// Count the faces of the mesh that intersect others.
  bool self_intersections = false;
  /// Distance, as a share of D, up to which a place counts as found: precision, recall and F-score. Range: > 0.
  double fscore_rel = 0.0025;
  /// Distance, as a share of D, beyond which surface counts as spurious or missing. Range: > 0.
  double far_rel = 0.01;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// Points on the faces of a mesh, in the units of its positions.
struct AreaSamples {
  std::vector<Vec3> positions;
  std::vector<Index> faces;  ///< face of each
};

/// `count` points uniform by area: the total area is cut into `count` equal strips in the order of the faces, and each
/// gets one point (stratified sampling), drawn from (seed, stream). The same bytes for any number of threads.
/// Throws InvariantError if the area is zero or not finite.
AreaSamples sample_surface(const Mesh& mesh, std::size_t count, std::uint64_t stream, const RunContext& context = {});

/// Distances of the points of a cloud to a surface in the cloud's frame, each counted with its weight (the number of
/// input points it stands for). The histogram is over distances relative to `diagonal` (scene units; 0: none). Throws
/// InvariantError if the surface is empty or a point is not finite.
DistanceReport measure_distances(const SurfaceDistance& surface, const PointCloud& cloud, double diagonal,
                                 const RunContext& context = {});

/// How far a cloud is from a mesh: points_to_surface, surface_to_points, mesh, and input.points and input.diagonal of
/// the report. D is the diagonal of the cloud. This measures agreement with the points, not accuracy: it sees no errors
/// that the points share. Surface that was made up where there are no points shows in surface_to_points, beside the
/// gaps between points.
/// Throws OptionError; InvariantError if the cloud has no points, the mesh no faces, or a number is not finite.
ErrorReport compare(const Mesh& mesh, const PointCloud& cloud, const CompareOptions& options = {},
                    const RunContext& context = {});

/// A mesh against ground truth, both ways, with normals: reference and mesh of the report. D is the diagonal of the
/// used vertices of the reference. Exact point-to-triangle distances from seeded samples (RunContext::seed). O((n +
/// samples) log n). Throws OptionError; InvariantError if one of them has no area or a number is not finite.
ErrorReport compare(const Mesh& mesh, const Mesh& reference, const CompareOptions& options = {},
                    const RunContext& context = {});

/// A cloud against a reference, both ways: reference and input of the report; all its points, each with its weight,
/// against samples of a mesh, or point to nearest point. D is the diagonal of the reference. Normals are compared where
/// both have them. Throws OptionError; InvariantError if one of them is empty or a number is not finite.
ErrorReport compare(const PointCloud& cloud, const Mesh& reference, const CompareOptions& options = {},
                    const RunContext& context = {});
ErrorReport compare(const PointCloud& cloud, const PointCloud& reference, const CompareOptions& options = {},
                    const RunContext& context = {});

/// `shape` with its positions (and normals, sensors) in `frame`.
Mesh moved_to(const Mesh& mesh, const Frame& frame);
PointCloud moved_to(const PointCloud& cloud, const Frame& frame);

}  // namespace gpsrecon
