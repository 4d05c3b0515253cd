#pragma once

#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/refinement_levels.h>

// Internal to lib/gps: colours and scalars of control vertices at the vertices of the refined mesh.

namespace gpsrecon::internal {

/// Gives `refined`, whose vertices are the samples of the surface, the colours and scalars of the control vertices. The
/// product of Gaussians averages means by their precisions; so are attributes, with the precision of each control
/// vertex within the surface (the trace of its inverse covariance without the largest eigenvalue) times its weight in
/// the limit position: where covariances are equal or isotropic within the surface, an affine function of position is
/// reproduced. All weights are positive, so nothing leaves the range of the input. The label of a sample is the one
/// with the largest sum of weights, the smallest of several. Missing numbers do not count; NaN where all are missing.
/// O(samples) per column.
void interpolate_attributes(const RefinementLevels<LoopScheme>& surface, const Mixture& control, Mesh& refined,
                            const RunContext& context);
void interpolate_attributes(const RefinementLevels<CatmullClarkScheme>& surface, const Mixture& control, Mesh& refined,
                            const RunContext& context);

/// The same where the vertices of `refined` are at `parameters`; those without a patch are control vertices of that
/// number.
void interpolate_attributes(const SurfaceEvaluator& surface, std::span<const SurfaceParameter> parameters,
                            const Mixture& control, Mesh& refined, const RunContext& context);

}  // namespace gpsrecon::internal
