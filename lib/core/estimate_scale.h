#pragma once

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/scale.h>

namespace gpsrecon::internal {

/// The same as in scale.h with an index of the points that is at hand.
Scale estimate_scale(const PointCloud& cloud, const Neighbors& index, const ScaleOptions& options = {},
                     const RunContext& context = {});

}  // namespace gpsrecon::internal
