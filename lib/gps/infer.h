#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/run_context.h>
#include <array>
#include <optional>
#include <string_view>

namespace gpsrecon {

enum class InferMethod {
  face,    ///< product of the Gaussians of the surrounding faces, Eq. 16 and 17: keeps features
  vertex,  ///< covariance of the vertex and its neighbours, Eq. 15
};

constexpr std::array<std::string_view, 2> option_names(InferMethod /*type*/) {
  return {"face", "vertex"};
}

struct InferOptions {
  InferMethod method = InferMethod::face;
  std::optional<double> bias = {};
  Length sigma0 = {};

  static constexpr double default_bias = 0.05;

  static OptionTable fields() {
    using O = InferOptions;
    return {
        field<&O::method>("method", "",
                          "covariance of a vertex: of the product of the Gaussians of its faces, which keeps "
                          "features, or of its neighbours"),
        field<&O::bias>("bias", "[1e-9, 1000]",
                        "variance added in all directions, in multiples of the largest of the face (or "
                        "neighbourhood), which keeps flat neighbourhoods invertible: the larger, the smoother")
            .or_else("0.05"),
        field<&O::sigma0>("sigma0", "> 0",
                          "standard deviation added in all directions, instead of --bias, but never less than a bias "
                          "of 1e-9 would be; auto = as --bias says")};
  }
  /// Throws OptionError naming option, range and value, or two that contradict each other.
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
