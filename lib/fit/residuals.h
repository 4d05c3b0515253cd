#pragma once

#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/gps/limit_surface.h>
#include <vector>

namespace gpsrecon::internal {

/// Which sample of a surface is closest to every point, and the point's signed offset along the normal there.
struct Assignment {
  std::vector<Index> sample;
  std::vector<double> offset;
};

/// Samples next to each other along the edges of the refined faces.
struct SampleGraph {
  std::vector<std::uint32_t> offset;
  std::vector<Index> next;
};
SampleGraph sample_graph(const LimitSurface& surface);

/// O(n log m).
Assignment assign_points(const SurfaceSamples& samples, const PointCloud& cloud, const RunContext& context);

/// Updates an assignment to samples that have moved little: from the sample of before, a walk along edges to ever
/// closer ones. O(n).
void reassign_points(const SurfaceSamples& samples, const SampleGraph& graph, const PointCloud& cloud,
                     const RunContext& context, Assignment& assignment);

/// Tuning constant of Tukey's biweight (95 % efficient on normal noise) times the standard deviation of normal noise
/// over its median magnitude: the offset at which a point counts for nothing, in median offsets.
inline constexpr double outlier_distance = 4.685 * 1.4826;

/// Median |offset| of all points.
double median_offset(const Assignment& assignment);

/// Sums over the points of each sample, with biweights: Σw, Σwd, Σwd² for offsets d.
struct Residuals {
  std::vector<double> weight, moment, square;
};

/// Points in `held_out` do not count. The scale of the biweight is the median |offset| around the sample's control
/// vertex, where that is more than `scale`, up to ten times that: points on a crease that the surface still rounds off
/// are no outliers.
Residuals robust_residuals(const LimitSurface& surface, const Assignment& assignment, const PointCloud& cloud,
                           const std::vector<char>& held_out, double scale);

}  // namespace gpsrecon::internal
