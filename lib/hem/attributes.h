#pragma once

#include <gpsrecon/core/attributes.h>
#include <gpsrecon/core/mixture.h>

// Internal to lib/hem: what points carry besides their positions, handed to the components they became part of.

namespace gpsrecon::internal {

/// Gives the mixture the colours and scalars of the cloud: component s has those of the points i with component_of[i]
/// == s, by their weights (core/attributes.h). Every component must have a point. O(n) per column, O(n log n) for
/// labels.
void carry_attributes(const PointCloud& cloud, std::span<const Index> component_of, Mixture& mixture,
                      const RunContext& context);

}  // namespace gpsrecon::internal
