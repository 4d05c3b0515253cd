#pragma once

#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/scan/scan_target.h>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace gpsrecon::internal {

/// How a surface is scanned: by cameras placed evenly around it that look at its centre, each measuring the distance
/// along the rays of a cone around it. Lengths may be given as shares of the diagonal of the surface's bounding box and
/// in scene units.
struct ScanOptions {
  std::size_t points = 100'000;
  int views = 24;
  double distance = 4;
  double max_incidence = 75;
  bool both_sides = false;
  Length noise = Length::of_diagonal(0);
  double noise_growth = 0;
  Length bias = Length::of_diagonal(0);
  Length registration_shift = Length::of_diagonal(0);
  double registration_angle = 0;
  double outlier_share = 0;
  double spike_share = 0;
  Length spike_length = Length::of_diagonal(0.03);

  static OptionTable fields() {
    using O = ScanOptions;
    return {
        field<&O::points>("points", "[1, 4294967294]", "number of points, outliers included"),
        field<&O::views>("views", "[1, 10000]", "number of cameras, placed evenly around"),
        field<&O::distance>("distance", "(1, 1000]",
                            "distance of the cameras from the centre, in radii of a ball around the surface"),
        field<&O::max_incidence>("max-incidence", "(0, 90]",
                                 "largest angle between ray and surface normal that still gives a point")
            .in("degrees"),
        field<&O::both_sides>("both-sides", "", "measure the back of the surface, too, as that of a thin sheet"),
        field<&O::noise>(
            "noise", ">= 0",
            "standard deviation of the measured distance, where the ray meets the surface at a right angle"),
        field<&O::noise_growth>(
            "noise-growth", "[0, 4]",
            "the noise grows towards grazing rays with the power X of 1 / cos(incidence), down to a "
            "cosine of 0.1"),
        field<&O::bias>("bias", ">= 0",
                        "amplitude of an error of the measured distance that varies slowly over each view"),
        field<&O::registration_shift>("registration", ">= 0", "standard deviation of the shift of a view, per axis"),
        field<&O::registration_angle>("registration-angle", "[0, 180]",
                                      "standard deviation of the rotation of a view about the centre, per axis")
            .in("degrees"),
        field<&O::outlier_share>(
            "outliers", "[0, 1]",
            "share of the points that lie at a random position on the part of their ray that is about "
            "the surface"),
        field<&O::spike_share>("spikes", "[0, 1]",
                               "share of the points that are moved along their ray, by a random length of either sign"),
        field<&O::spike_length>("spike-length", ">= 0", "by at most this")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const;
};

/// From a clean, dense scan to one whose noise is wider than its spacing; see scan_quality().
enum class ScanQuality { s1, s2, s3 };
constexpr std::array<std::string_view, 3> option_names(ScanQuality /*type*/) {
  return {"s1", "s2", "s3"};
}

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

}  // namespace gpsrecon::internal
