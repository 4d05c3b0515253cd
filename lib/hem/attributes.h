#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <span>

// Internal to lib/hem: what points carry besides their positions, handed to the components they became part of.

namespace gpsrecon {

inline bool has_attributes(const PointCloud& cloud) {
  return !cloud.colors.empty() || !cloud.scalars.empty();
}

/// Gives the mixture the colours and scalars of the cloud: component s those of the points i with component_of[i] == s,
/// each with its weight. Colours and quantities are averaged, colours rounded; the label is the one with the largest
/// weight, the smallest of several. Missing numbers do not count; where all are missing the result is NaN. Every
/// component must have a point. O(n) per column, O(n log n) for labels.
void carry_attributes(const PointCloud& cloud, std::span<const Index> component_of, Mixture& mixture,
                      const RunContext& context);

}  // namespace gpsrecon
