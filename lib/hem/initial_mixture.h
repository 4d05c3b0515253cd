#pragma once

#include <gpsrecon/hem/hem.h>

namespace gpsrecon {

/// Level 0 of the hierarchy: one Gaussian per point (Preiner et al. 2014, section 5.3, Eq. 12, 26; design of σ0 in
/// HemOptions). Precondition: options.sigma0 > 0, and options.spacing > 0 for local covariances and balanced weights.
Mixture initial_mixture(const PointCloud& cloud, const HemOptions& options, const RunContext& context);

}  // namespace gpsrecon
