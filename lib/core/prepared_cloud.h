#pragma once

#include <gpsrecon/core/length.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/core/scale.h>
#include <memory>
#include <optional>

namespace gpsrecon {

namespace internal {
class Neighbors;
}

/// A cloud that the stages can work on: clean, with its scale and one index of its points for all of them. Lengths in
/// the units of the positions.
struct PreparedCloud {
  PointCloud cloud;           ///< finite, distinct points in local coordinates, in an order close in space
  std::vector<Index> source;  ///< per point of `cloud`: its row in the input (the first one of coincident points)
  std::size_t rows = 0;       ///< of the input
  std::size_t non_finite = 0, duplicates = 0;            ///< rows dropped, or merged into an equal one
  std::size_t isolated = 0;                              ///< points dropped because they are far from all others
  Scale scale;                                           ///< `isolated` refers to the points before they were dropped
  double diagonal = 0;                                   ///< of the bounding box
  std::shared_ptr<const internal::Neighbors> neighbors;  ///< of the positions, for the stages
  /// Where the sensor stood, in world coordinates; takes precedence over the sensors and normals of the points.
  std::optional<Vec3> sensor;

  /// What options that are lengths refer to.
  LengthScale lengths() const;
  /// The diagonal in scene units.
  double scene_diagonal() const { return diagonal * cloud.frame.scale(); }
  /// Other points of the same surface, of the same scale, without rows of the input. O(n log n).
  PreparedCloud with_points(PointCloud points) const;
};

/// Cleans a cloud in world coordinates (drops rows that are not finite, merges exact duplicates into one weight,
/// centres and scales it to a diagonal of 1 to 2, orders it along a curve), estimates its scale (core/scale.h) and
/// drops isolated points. O(n log n). Throws OptionError; InputError if no point is finite; NoSurfaceError if the rest
/// is one or two points, equal or on a line; Cancelled.
PreparedCloud prepare(const PointCloud& world, const ScaleOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
