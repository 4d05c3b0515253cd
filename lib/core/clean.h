#pragma once

#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>

namespace gpsrecon::internal {

/// A cloud made fit for work, and what became of the points it was made from.
struct CleanCloud {
  PointCloud cloud;            ///< finite, distinct points in local coordinates, in an order close in space
  std::vector<Index> source;   ///< per point of `cloud`: its index in the input (the first one of coincident points)
  std::size_t non_finite = 0;  ///< rows dropped because a coordinate was NaN or infinite
  std::size_t duplicates = 0;  ///< points merged into an equal one, whose weight counts them
};

/// Drops rows that are not finite, merges exact duplicates into one weight (attributes of the first), chooses the frame
/// (centred on the robust box of 1 % to 99 % quantiles per axis, scaled by a power of two so that its diagonal is in
/// [1, 2)) and orders the points along a Morton curve. The order, like all that follows from it, depends neither on
/// the order of the input nor on its units. The frame of the input must be the identity.
/// O(n log n). Throws InputError if no point is finite.
CleanCloud clean(const PointCloud& world, const RunContext& context = {});

}  // namespace gpsrecon::internal
