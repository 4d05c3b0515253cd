#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/fit/residuals.h>
#include <array>

namespace gpsrecon::internal {

/// The ends of every edge of a control mesh.
using ControlEdges = std::vector<std::array<Index, 2>>;
ControlEdges control_edges(const Connectivity& topology);

/// How far each control vertex is to move along its normal: some conjugate-gradient iterations on the normal equations
/// of Σ_s w_s (a_s·x - d_s)², where a_si = (Σn)ᵀ α_i Σ_i⁻¹ n_i is what sample s moves along its normal for a unit move
/// of vertex i, with priors on the moves of all steps together, `moved` + x. O(m) per iteration for m samples.
std::vector<double> solve_moves(const LimitSurface& surface, const Mixture& control, const ControlEdges& edges,
                                const SurfaceSamples& samples, const Residuals& residuals,
                                const std::vector<double>& moved, const RunContext& context);

}  // namespace gpsrecon::internal
