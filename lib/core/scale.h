#pragma once

#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>

namespace gpsrecon {

struct ScaleOptions {
  double isolation = 4;

  static OptionTable fields() {
    return {
        field<&ScaleOptions::isolation>("isolation", "> 1 or 0",
                                        "drop points whose 8th neighbour is farther than X times the median such "
                                        "distance, unless those around are as sparse and lie in a sheet; 0 keeps all")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// What the cloud says about its own resolution. Lengths in the units of the positions.
struct Scale {
  double spacing = 0;  ///< A: side of the area per point
  double noise = 0;    ///< ν: standard deviation of the points across the surface, median over the cloud
  /// Median of the smallest principal deviation of 48 points: what noise, curvature and edges make together, as far as
  /// neighbours reach.
  double thickness = 0;
  bool thin_walls = false;  ///< whether much of the cloud lies in such: `noise` is then that of one of their sheets
  double sigma0 = 0;        ///< kernel width for isotropic first Gaussians: sqrt(A² + ν²)
  /// Kernel width for first Gaussians of local covariance, which span the spacing by themselves: sqrt((0.4 A)² +
  /// (1.6 ν)²). Just wide enough that the sheet is one Gaussian thick, in clean scans as in noisy ones.
  double sigma0_local = 0;
  std::vector<double> spacing_at;  ///< per point: the same where the cloud is sparser or denser, smooth over space
  std::vector<double> noise_at;    ///< likewise
  std::vector<Index> isolated;     ///< points that are too far from all others to belong to a surface, ascending
};

/// Sample spacing from the distance d8 to the 8th neighbour, A = median(d8) sqrt(π/9), noise from the smallest
/// principal deviation of 48 points (where a fifth of the neighbourhoods shows two sheets, the sides of thin walls, of
/// those in the same sheet), and the kernel width of the first mixture level from both. Both are then compared with
/// local measures, which know repeated points, scan lines, curvature and noise larger than the spacing from a sheet
/// sampled evenly, and give way where the difference is larger than the error of these. Weights are ignored. O(n log
/// n). Throws OptionError; NoSurfaceError if fewer than three points are given.
Scale estimate_scale(const PointCloud& cloud, const ScaleOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
