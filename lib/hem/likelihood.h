#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/run_context.h>
#include <span>
#include <vector>

namespace gpsrecon::internal {

struct LikelihoodOptions {
  double outlier_share = 0.01;
  double outlier_volume = 1;
  double reach = 6;

  static OptionTable fields() {
    return {field<&LikelihoodOptions::outlier_share>(
                "outlier-share", "(0, 1)",
                "share of a uniform distribution that is mixed in, so that outliers do not decide"),
            field<&LikelihoodOptions::outlier_volume>("outlier-volume", "> 0", "volume of that distribution")
                .in("cubed units of the positions"),
            field<&LikelihoodOptions::reach>(
                "reach", "> 0", "components whose Mahalanobis distance from a point is larger do not count there")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// ln p(x) of every point, p(x) = (1 - ε) Σ_s w_s / w f_s(x) + ε / V with f_s as in core/gaussian.h, w the total
/// weight, ε and V share and volume of the outliers. What lies beyond reach 6 is below 2e-8 of the densities at the
/// means. Mixture and points in the same frame. O(n k) for n points within reach of k components each; O(log m) more to
/// find them. Throws OptionError, InvariantError for an empty mixture, Cancelled.
std::vector<double> log_likelihoods(const Mixture& mixture, std::span<const Vec3> points,
                                    const LikelihoodOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon::internal
