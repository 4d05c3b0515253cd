#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>

namespace gpsrecon {

enum class InferMethod {
  face,    ///< product of the Gaussians of the surrounding faces, Eq. 16 and 17: keeps features
  vertex,  ///< covariance of the vertex and its neighbours, Eq. 15
};

struct InferOptions {
  InferMethod method = InferMethod::face;
  /// Added to the diagonal of each face's (or vertex neighbourhood's) population covariance, in multiples of its
  /// largest eigenvalue: what keeps flat neighbourhoods invertible. Range: [1e-9, 1e3].
  double bias = 0.05;
  /// The same as an absolute standard deviation in world units, whose square is added in place of `bias`; never less
  /// than a `bias` of 1e-9 would be. 0 = use `bias`. Range: 0 or [1e-100, 1e100].
  double sigma0 = 0;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// A covariance mesh inferred from an ordinary one, and what could not be used for it.
struct Inference {
  CovMesh mesh;                      ///< same vertices, colours, scalars and faces; weights 1, σ0 = 0; rules_for()
  std::size_t degenerate_faces = 0;  ///< faces without area: they stay, but say nothing about covariances
  std::size_t vertices_without_neighborhood = 0;  ///< used by no (other than degenerate) face: given the mean precision
                                                  ///< of their neighbours, ring by ring, or where there are none the
                                                  ///< median trace of all others, isotropic
};

/// Gives the vertices of a polygon mesh covariances from the geometry around them (Preiner et al. 2019, section 6.1).
/// Commutes with similarities, if `sigma0` is scaled too; the vertex method with a small bias, where neighbourhoods are
/// not flat, nearly so with every affine map.
/// Throws OptionError; InvariantError if the mesh is not a valid, manifold and consistently oriented mesh;
/// NoSurfaceError if every face is degenerate. O(c log c) in the number of corners.
Inference infer_covariances(const Mesh& mesh, const InferOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
