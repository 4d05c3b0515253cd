#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/measure/statistics.h>
#include <span>
#include <vector>

namespace gpsrecon::internal {

// The density ridge of a mixture f: the surface of the points at which f is largest across the surface, that is, the
// gradient of f has no part along v, the direction in which ln f is curved downward most (the eigenvector of
// -∇∇ᵀ ln f with the largest eigenvalue, which is positive). Ozertem & Erdogmus: Locally defined principal curves and
// surfaces, JMLR 12, 2011, for d = 2. It is what a surface made of a mixture should resemble, but has gaps and branches
// where v jumps (Preiner et al. 2019, section 2.1, Figures 2 and 15).

struct RidgeOptions {
  /// Steps per point, at most. Range: [1, 100000].
  int max_steps = 300;
  /// A step this long ends the search, in local deviations of the mixture across the surface. Range: (0, 0.1].
  double tolerance = 1e-6;
  /// Components farther from a point, in their deviations, have no part in the density there. Range: [3, 30].
  double reach = 7;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// Where a point came to rest.
struct RidgePoint {
  Vec3 position = Vec3::Zero();
  Vec3 across = Vec3::Zero();  ///< v, unit, of either sign; zero where there is no density
  bool on_ridge = false;       ///< within the tolerance of a ridge; else it ran out of steps, or there is none
};

/// Moves each point to the ridge by a subspace-constrained mean shift: steps along v to the maximum of the lower bound
/// of f that expectation maximisation gives, vᵀg / vᵀMv with M = Σ r_i Σ_i⁻¹, g = ∇ ln f = Σ r_i Σ_i⁻¹ (μ_i - x) and
/// the responsibilities r_i. No step lowers f, and points at rest have vᵀg = 0 for any covariances (those of the step
/// V Vᵀ(m(x) - x) along the full mean shift m have it only where M maps v to a multiple of itself).
/// Points in units of the mixture's means. Rotates, moves and scales with mixture and points. O(points · steps ·
/// components within reach). Throws OptionError; InvariantError if the mixture is empty or a point is not finite;
/// Cancelled.
std::vector<RidgePoint> project_to_ridge(const Mixture& mixture, std::span<const Vec3> points,
                                         const RidgeOptions& options = {}, const RunContext& context = {});

/// How far points lie from the ridge.
struct RidgeDistance {
  Statistics distance;   ///< way from point to ridge, of those points that reach it; units of the points
  std::size_t lost = 0;  ///< points that do not reach a ridge
};

/// Precondition: one `found` per point, as project_to_ridge() gives them.
RidgeDistance ridge_distance(std::span<const Vec3> points, std::span<const RidgePoint> found,
                             const RunContext& context = {});

}  // namespace gpsrecon::internal
