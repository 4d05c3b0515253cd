#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <span>

namespace gpsrecon::internal {

inline bool has_attributes(const PointCloud& cloud) {
  return !cloud.colors.empty() || !cloud.scalars.empty();
}

/// A point, and how much it counts.
struct WeightedPoint {
  Index point;
  double weight;  ///< > 0
};

/// The weighted average, rounded. Precondition: there are points.
Color mean_color(const std::vector<Color>& colors, std::span<const WeightedPoint> points);

/// The weighted average of a quantity; the label with the largest weight, the smallest of several. Missing numbers do
/// not count: NaN if there are no others.
double combine(const ScalarColumn& column, std::span<const WeightedPoint> points);

/// Gives every vertex of the mesh the colour and the scalars of the points around it, in place of those it has: of its
/// eight nearest ones, with biweights that vanish a little beyond the farthest of them. That is as sharp as the points
/// are dense, wherever they are, and averages their noise. Cloud and mesh must be in the same frame.
/// O((n + m) log n) for n points and m vertices. Without points, or attributes of theirs, nothing changes.
void attributes_from_points(Mesh& mesh, const PointCloud& cloud, const RunContext& context = {});

}  // namespace gpsrecon::internal
