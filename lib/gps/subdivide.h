#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>

namespace gpsrecon {

struct SubdivideOptions {
  /// Number of refinement steps. Range: [0, 8].
  int levels = 2;
  /// Push the vertices of the last level to their limit positions and give limit normals; otherwise the vertices of the
  /// last level themselves, with normals of the same limit surface.
  bool limit = true;
  /// Instead of `levels` everywhere, split faces until the mesh is nowhere farther from the limit surface than this, in
  /// units of the control means; faces become triangles. Needs limit. Range: > 0; 0 = levels.
  double tolerance = 0;
  /// Give the vertices the curvatures of the limit surface there, as scalars: mean_curvature and the principal
  /// curvatures k1 >= k2 in 1/length, gaussian_curvature in 1/length² (all in world units, positive where the surface
  /// bends away from the normal), the directions k1x ... k2z, and curvature_exact, 0 at irregular control vertices,
  /// where it may be infinite and is taken around the vertex (evaluate.h).
  bool curvature = false;
  /// Give the vertices their covariances.
  bool covariances = false;
  /// Give the refined vertices the colours and scalars of the control vertices, if these have any.
  bool attributes = true;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// Gaussian-product subdivision of a covariance mesh by its own rules: linear refinement of the dual
/// points q = (vech Σ⁻¹, Σ⁻¹μ) in R⁹, mapped back by μ = [q̂]⁻¹ q̄ (Preiner et al. 2019, section 4, Eq. 11-13). The
/// result has positions, unit normals (appendix B) and `sigma` = sqrt(max(0, nᵀΣn - σ0²)) per vertex, in the frame of
/// the input, and the colours and scalars of the control vertices: averages by weights of the limit position times
/// precision within the surface; labels by the largest sum of these. Level L has 4^L times the faces (with
/// Scheme::catmull_clark 4^(L-1) times the corners, all quadrilaterals). O(size of the result). Throws OptionError;
/// InvariantError if the mesh is not a valid covariance mesh or, with Scheme::loop, not triangular.
Mesh subdivide(const CovMesh& mesh, const SubdivideOptions& options = {}, const RunContext& context = {});

/// The smallest level <= max_level at which the mean edge is no longer than `target_edge`. Throws nothing.
int level_for_edge_length(const CovMesh& mesh, double target_edge, int max_level = 3);

}  // namespace gpsrecon
