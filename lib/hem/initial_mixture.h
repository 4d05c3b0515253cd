#pragma once

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/hem/hem.h>

namespace gpsrecon::internal {

/// Kernel width and sample spacing in the units of the positions.
struct Kernel {
  double sigma0 = 0;
  double spacing = 0;
  std::vector<double> sigma0_at = {}, spacing_at = {};  ///< per point where they differ, or empty
};

/// Level 0 of the hierarchy: one Gaussian per point (Preiner et al. 2014, section 5.3, Eq. 12, 26; design of σ0 in
/// HemOptions). Its lengths are those of `kernel`. Precondition: sigma0 > 0, and spacing > 0 for local covariances and
/// balanced weights; `index` is that of the points.
Mixture initial_mixture(const PointCloud& cloud, const Neighbors& index, const Kernel& kernel,
                        const HemOptions& options, const RunContext& context);

}  // namespace gpsrecon::internal
