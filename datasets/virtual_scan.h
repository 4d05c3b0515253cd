#pragma once

#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <vector>

#include "datasets/shapes.h"

namespace gpsrecon::datasets {

/// How a solid is scanned: by cameras placed evenly around it that look at its centre, each measuring the distance
/// along the rays of a cone around the solid. Lengths in the units of the solid.
struct ScanOptions {
  /// Number of points, outliers included. Range: [1, 2^32 - 2].
  std::size_t points = 100'000;
  /// Number of cameras. Range: [1, 10000].
  int views = 24;
  /// Distance of the cameras from the centre, as a multiple of the bounding radius. Range: (1, 1000].
  double distance = 4;
  /// Largest angle between ray and surface normal that still gives a point, in radians. Range: (0, π/2].
  double max_incidence = 1.3;
  /// Standard deviation of the measured distance, along the ray. Range: >= 0.
  double noise = 0;
  /// Standard deviation of the position of a view, per axis. Range: >= 0.
  double registration_shift = 0;
  /// Standard deviation of the rotation of a view about the centre, per axis, in radians. Range: >= 0.
  double registration_angle = 0;
  /// How many of the points are outliers: at a random place of the part of their ray that is about the solid.
  /// Range: [0, points].
  std::size_t outliers = 0;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// Points ordered by view. Attributes of `cloud`: `normals`, the outward normals of the solid where the rays met it,
/// and `sensors`, where the cameras stood; both move with the registration error of their view.
struct VirtualScan {
  PointCloud cloud;
  std::vector<Vec3> surface;    ///< per point: where the ray met the solid, without any error
  std::vector<Index> view;      ///< per point: the camera
  std::vector<Index> outliers;  ///< points that are outliers, ascending; their normals are those of the missed surface
};

/// Scans the visible surface of a solid. The points are spread over the images of the cameras by a low-discrepancy
/// sequence, so that their density on the surface varies with distance and incidence as that of a scanner does.
/// Rays are followed until they are within 1e-10 bounding radii of the surface.
/// A function of solid, options and context.seed only. O(points) distance evaluations of the solid, some dozens each.
/// Throws OptionError; NoSurfaceError if no ray meets the solid at a sufficient angle; Cancelled.
VirtualScan scan(const Solid& solid, const ScanOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon::datasets
