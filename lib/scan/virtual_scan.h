#pragma once

#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/scan/scan_target.h>
#include <cstdint>
#include <numbers>
#include <vector>

namespace gpsrecon {

/// How a surface is scanned: by cameras placed evenly around it that look at its centre, each measuring the distance
/// along the rays of a cone around it. D is the diagonal of the surface's bounding box.
struct ScanOptions {
  /// Number of points, outliers included. Range: [1, 2^32 - 2].
  std::size_t points = 100'000;
  /// Number of cameras. Range: [1, 10000].
  int views = 24;
  /// Distance of the cameras from the centre, as a multiple of the bounding radius. Range: (1, 1000].
  double distance = 4;
  /// Largest angle between ray and surface normal that still gives a point, in radians. Range: (0, π/2].
  double max_incidence = 75 * std::numbers::pi / 180;
  /// Whether the back of the surface is measured too, as that of a thin sheet.
  bool both_sides = false;
  /// Standard deviation of the measured distance where the ray meets the surface at a right angle, in D. Range: >= 0.
  double noise_rel = 0;
  /// Power of 1 / cos(incidence) by which the noise grows towards grazing rays (down to a cosine of 0.1).
  /// Range: [0, 4].
  double noise_growth = 0;
  /// Amplitude of an error of the measured distance that varies slowly over the image of each view, in D. Range: >= 0.
  double bias_rel = 0;
  /// Standard deviation of the position of a view, per axis, in D. Range: >= 0.
  double registration_shift_rel = 0;
  /// Standard deviation of the rotation of a view about the centre, per axis, in radians. Range: [0, π].
  double registration_angle = 0;
  /// Share of the points that are outliers: at a random place of the part of their ray that is about the surface.
  /// Range: [0, 1].
  double outlier_share = 0;
  /// Share of the points that are spikes: moved along their ray by a random length of either sign. Range: [0, 1], with
  /// the outliers at most 1.
  double spike_share = 0;
  /// Largest such length, in D. Range: >= 0.
  double spike_rel = 0.03;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// From a clean, dense scan to one whose noise is wider than its spacing; see scan_quality().
enum class ScanQuality { s1, s2, s3 };

/// Three grades of scan with 3 radii between camera and centre and noise that grows with the root of 1 /
/// cos(incidence).
///
/// |    | points  | views | noise  | bias  | registration, shift and angle | outliers | spikes | incidence |
/// | s1 | 300,000 | 24    | 0.02 % |       |                               |          |        | 81°       |
/// | s2 | 150,000 | 16    | 0.1 %  |       | 0.04 %, 0.03°                 | 0.1 %    |        | 81°       |
/// | s3 | 75,000  | 12    | 0.25 % | 0.1 % | 0.12 %, 0.1°                  | 1 %      | 0.5 %  | 72°       |
///
/// Registration errors are here those of the whole shift and rotation, √3 times those per axis.
ScanOptions scan_quality(ScanQuality quality);

/// Points ordered by view. Attributes of `cloud`: `normals`, the outward normals of the surface where the rays met it
/// (turned to the camera where both sides are measured), and `sensors`, where the cameras stood; both move with the
/// registration error of their view.
struct VirtualScan {
  PointCloud cloud;
  std::vector<Vec3> surface;    ///< per point: where the ray met the surface, without any error
  std::vector<Index> view;      ///< per point: the camera
  std::vector<Index> outliers;  ///< points that are outliers, ascending; their normals are those of the missed surface
  std::vector<Index> spikes;    ///< points that are spikes, ascending
};

/// Scans the visible surface of a target. The points are spread over the images of the cameras by a low-discrepancy
/// sequence, so that their density on the surface varies with distance and incidence as that of a scanner does.
/// A function of target, options and context.seed only. O(points) rays. Throws OptionError; NoSurfaceError if no ray
/// meets the surface at a sufficient angle; Cancelled.
VirtualScan virtual_scan(const ScanTarget& target, const ScanOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
