#pragma once

#include <gpsrecon/core/run_context.h>
#include <gpsrecon/core/vec.h>
#include <span>

// Internal to lib/clop: what spreads the particles.

namespace gpsrecon::internal {

/// F2 of every particle, Preiner et al. 2014, Eq. 5-6 with η(r) = -r: the mean way from its neighbours, by their
/// weights θ(r)/r. Particles beyond the cut-off, a share of the support radius, are left out (section 8). Both spans
/// have the same length.
void update_repulsion(std::span<const Vec3> particles, double support_radius, double cutoff, std::span<Vec3> repulsion,
                      const RunContext& context);

}  // namespace gpsrecon::internal
