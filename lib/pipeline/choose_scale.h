#pragma once

#include <gpsrecon/pipeline/reconstruct.h>

namespace gpsrecon::internal {

/// The kernel that a budget or a bound of the error leads to.
struct ScaleChoice {
  ReconstructOptions options;               ///< with `hem.detail` and `fit.max_vertices` filled in
  std::optional<ScaleSearchReport> search;  ///< what was tried, if anything was
  std::string words;                        ///< to be added to KernelStatistics::choice
};

/// The options with what `budget` or `max_error` ask for filled in, `hem.detail` and `fit.max_vertices`; as they are if
/// neither is given. What was tried goes into the report (`scale.search`), what could not be had into its warnings.
///
/// Budget N: if the automatic mixture and its triangulation have at most N vertices they stay, and the fit is limited
/// to N. If not, the kernel width for four fifths of N Gaussians is found by secants of the logarithm of their number,
/// and the fit adds the rest where the points show detail.
///
/// Error X: one point in eight is held out, the chain is run on the others with kernels 2^(k/2) times the automatic
/// one, the share of the vertices that the fit may add the same as for a budget, and the widest whose held_out_error()
/// is at most X is found by bisection of k in [0, 6].
///
/// A dozen runs of the mixture for a budget, four runs of the chain for an error, at most. Throws OptionError if not
/// even the coarsest mixture is within the budget or no surface comes out of it, and what the stages throw.
ScaleChoice choose_scale(const PreparedCloud& cloud, const ReconstructOptions& options, const RunContext& context);

/// Held-out log-likelihood (hem/likelihood.h) of the mixture for kernels of 0.5 to 2 times the automatic one: a fifth
/// of the points is held out, the mixtures are made of the others. Changes nothing but the report (`scale.check`).
std::optional<ScaleCheckReport> check_scale(const PreparedCloud& cloud, const ReconstructOptions& options,
                                            const RunContext& context);

}  // namespace gpsrecon::internal
