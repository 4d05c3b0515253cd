#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/prepared_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <optional>

namespace gpsrecon {

struct SubdivideOptions {
  std::optional<int> levels = {};
  /// Push the vertices of the last level to their limit positions and give limit normals; otherwise the vertices of the
  /// last level themselves, with normals of the same limit surface.
  bool limit = true;
  std::optional<Length> tolerance = {};
  bool curvature = false;
  bool covariances = false;
  bool attributes = true;

  static OptionTable fields() {
    using O = SubdivideOptions;
    return {
        field<&O::levels>(
            "levels", "[0, 8]",
            "refinement level of the mesh; auto = the smallest up to 3 whose edges are at most 1.5 sample "
            "spacings, at least 1 with --scheme catmull-clark")
            .or_else("auto"),
        field<&O::tolerance>(
            "tolerance", "> 0",
            "instead of levels: split faces until the mesh is nowhere farther than LENGTH from the limit "
            "surface, so that flat regions stay coarse; faces become triangles"),
        field<&O::limit>("limit", "", "push the vertices to their limit positions").only_in_library(),
        field<&O::curvature>(
            "curvature", "",
            "give the vertices curvatures, in 1/length, positive where the surface bends away from the "
            "normal: mean_curvature, gaussian_curvature, k1, k2, their directions and whether they are "
            "exact (ply)"),
        field<&O::covariances>("covariances", "",
                               "give the vertices their covariances (ply): the mesh then is a covariance mesh itself"),
        field<&O::attributes>("attributes", "", "give the vertices the colours and scalars of the control vertices")
            .only_in_library()};
  }
  /// Throws OptionError naming option, range and value, or two that contradict each other.
  void check() const;
};

/// Gaussian-product subdivision of a covariance mesh by its own rules: linear refinement of the dual
/// points q = (vech Σ⁻¹, Σ⁻¹μ) in R⁹, mapped back by μ = [q̂]⁻¹ q̄ (Preiner et al. 2019, section 4, Eq. 11-13). The
/// result has positions, unit normals (appendix B) and `sigma` = sqrt(max(0, nᵀΣn - σ0²)) per vertex, in the frame of
/// the input, and the colours and scalars of the control vertices: averages by weights of the limit position times
/// precision within the surface; labels by the largest sum of these. Level L has 4^L times the faces (with
/// Scheme::catmull_clark 4^(L-1) times the corners, all quadrilaterals). A tolerance that is a share of the diagonal is
/// of that of the control means. O(size of the result). Throws OptionError;
/// InvariantError if the mesh is not a valid covariance mesh or, with Scheme::loop, not triangular.
Mesh subdivide(const ConnectedMesh& mesh, const SubdivideOptions& options = {}, const RunContext& context = {});

/// The same with the points at hand: their colours and scalars (core/attributes.h) instead of the coarser ones of the
/// Gaussians, and a tolerance that is a share of the diagonal is of theirs.
Mesh subdivide(const ConnectedMesh& mesh, const PreparedCloud& cloud, const SubdivideOptions& options = {},
               const RunContext& context = {});

/// The level that a mesh is refined to unless options say otherwise: the smallest up to 3 whose edges are at most half
/// longer than the sample spacing, and where that is not known 3; with Scheme::catmull_clark at least 1.
int automatic_level(const ConnectedMesh& mesh);

/// The smallest level <= max_level at which the mean edge is no longer than `target_edge`. Throws nothing.
int level_for_edge_length(const ConnectedMesh& mesh, double target_edge, int max_level = 3);

}  // namespace gpsrecon
