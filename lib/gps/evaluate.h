#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/core/sym3.h>
#include <gpsrecon/gps/surface_weights.h>
#include <memory>
#include <span>
#include <vector>

namespace gpsrecon {

/// The surface at a parameter, in the units of the control means.
struct SurfacePoint {
  Vec3 position;
  Vec3 u, v;        ///< μ_u, μ_v: derivatives by the parameters of the patch (appendix B)
  Vec3 uu, uv, vv;  ///< second derivatives
  Vec3 normal;      ///< unit, on the side from which faces run counter-clockwise; zero where tangents span no plane
  Sym3 covariance;  ///< of the Gaussian there
  /// The point is a vertex of irregular valence, where derivatives by the parameters need not exist: position, normal
  /// and covariance are those of the vertex, the derivatives those at a parameter distance of extraordinary_offset in u
  /// and v from it.
  bool extraordinary = false;
};

/// Coefficients of the first (E, F, G) and second (L, M, N = normal · second derivatives) fundamental form.
struct FundamentalForms {
  double E, F, G, L, M, N;
};
FundamentalForms fundamental_forms(const SurfacePoint& point);

/// Curvature of a surface at a point, in units of 1/length: positive where the surface bends away from the normal, as
/// everywhere on a sphere seen from outside.
struct Curvature {
  double mean = 0, gaussian = 0;
  double k1 = 0, k2 = 0;                                      ///< principal curvatures, k1 >= k2
  Vec3 direction1 = Vec3::Zero(), direction2 = Vec3::Zero();  ///< their unit directions, each of either sign
  bool exact = true;  ///< false: of an irregular vertex, taken around it; or, all zero, where there is no tangent plane
};

/// From the derivatives. All zero and not exact where the tangents do not span a plane. Never NaN.
Curvature curvature(const SurfacePoint& point);

/// Exact evaluation of the limit surface of a covariance mesh anywhere: the linear limit surface in R⁹ and its first
/// and second derivatives, by the weights of surface_weights(), mapped to space by appendix B of Preiner et al. 2019.
class SurfaceEvaluator {
 public:
  /// Makes a table of about 60 numbers per face. Throws InvariantError if the mesh is not a valid covariance mesh, or
  /// not triangular with Scheme::loop. O(n).
  explicit SurfaceEvaluator(const ConnectedMesh& mesh, const RunContext& context = {});

  std::size_t patch_count() const;
  /// Precondition: face is one of the mesh.
  Index first_patch(std::size_t face) const;
  std::size_t patches_of(std::size_t face) const;

  /// The basis functions of the surface: surface_weights(), with what depends on the mesh alone at hand.
  JetTable weights(std::span<const SurfaceParameter> parameters, const RunContext& context = {}) const;

  /// All derivatives at each parameter, in parallel. Throws OptionError for parameters outside their patches.
  std::vector<SurfacePoint> evaluate(std::span<const SurfaceParameter> parameters,
                                     const RunContext& context = {}) const;
  SurfacePoint evaluate(const SurfaceParameter& parameter) const;

  /// Curvatures. At an irregular vertex that of the surface may be infinite: there the curvature tensors at a parameter
  /// distance of extraordinary_offset in u and v on each face around are averaged in the tangent plane of the vertex,
  /// and the result is marked not exact.
  std::vector<Curvature> curvatures(std::span<const SurfaceParameter> parameters, const RunContext& context = {}) const;

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

}  // namespace gpsrecon
