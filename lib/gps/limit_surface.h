#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/stencils.h>

namespace gpsrecon::internal {

/// One entry per sample of a LimitSurface.
struct SurfaceSamples {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< unit, on the side from which faces run counter-clockwise
  std::vector<double> sigma;  ///< sqrt(max(0, nᵀΣn - σ0²)), in units of `positions`
  std::vector<Vec3> spread;  ///< Σn: how the position follows the Gaussians, δ(nᵀμ) = (Σn)ᵀ Σ_i α_i Σ_i⁻¹ δμ_i
  std::vector<Sym3> covariances;  ///< Σ; not from LimitSurface
};

/// Everything about a Gaussian-product surface that depends on connectivity alone: the faces of a refinement
/// level, the stencils of every step down to it and the limit masks there. Built once, it evaluates the surface for any
/// Gaussians at the control vertices, and carries data between control vertices and samples. A sample is a vertex of
/// the refined faces; sample i < control_count() belongs to control vertex i. Memory: about 200 bytes per sample, their
/// connectivity included.
class LimitSurface {
 public:
  /// `control` is manifold and consistently oriented, with Scheme::loop of triangles; levels >= 0. With
  /// Scheme::catmull_clark the samples of a level are its old vertices, one per edge and one per face, and the refined
  /// faces quadrilaterals. Throws InvariantError for faces of other sizes; OptionError if the level has more faces than
  /// indices can count, or is 0 for Scheme::catmull_clark and faces of other than four corners, whose limit positions
  /// have no masks.
  LimitSurface(const Connectivity& control, int levels, const SurfaceRules& rules = {}, const RunContext& context = {});
  /// The same by manifold_connectivity().
  LimitSurface(const FaceList& faces, std::size_t control_count, int levels, const SurfaceRules& rules = {},
               const RunContext& context = {});

  std::size_t control_count() const { return control_count_; }
  std::size_t sample_count() const { return limit_.rows(); }
  const FaceList& faces() const& { return faces_; }
  /// Connectivity of the refined faces.
  const Connectivity& connectivity() const& { return connectivity_; }

  /// The surface of the Gaussians `control` (a valid mixture of control_count() components). With limit = false the
  /// positions and deviations are those of the refined vertices themselves instead of their limits.
  /// Where the tangents do not span a plane the normal is that of the surrounding refined faces, or, failing that, the
  /// thin axis of the Gaussian (of either sign). O(sample_count()).
  SurfaceSamples evaluate(const Mixture& control, bool limit = true, const RunContext& context = {}) const;

  /// The weights α of the limit positions, applied to one value (number or fixed-size Eigen vector) per control vertex:
  /// Σ_i α_i(u) values[i] at every sample u. Where all covariances are equal these are the limit positions of the
  /// means.
  template <class T>
  std::vector<T> to_samples(std::span<const T> values, const RunContext& context = {}) const;

  /// The transpose of to_samples: Σ_u α_i(u) values[u] at every control vertex i. The order of summation is fixed.
  template <class T>
  std::vector<T> to_control(std::span<const T> values) const {
    return to_level<T>(values, 0);
  }
  /// The same for the vertices of refinement level `level` in place of the control vertices, with the weights they
  /// would have. Precondition: level <= levels.
  template <class T>
  std::vector<T> to_level(std::span<const T> values, std::size_t level) const;

  /// Per sample the control vertex it grew from: itself, or of the ends of the edge or the corners of the face it was
  /// put on the one that grew from the vertex with the smallest number, so that the order of the faces does not matter.
  std::vector<Index> control_of_samples() const;

 private:
  std::size_t control_count_;
  FaceList faces_;
  Connectivity connectivity_;
  std::vector<RefinementStep<StencilTable, StencilTable>> steps_;
  LimitTable limit_;
};

template <class T>
std::vector<T> LimitSurface::to_samples(std::span<const T> values, const RunContext& context) const {
  std::vector<T> current(values.begin(), values.end());
  for (const auto& step : steps_) current = refine_values<T>(step, current, context);
  std::vector<T> samples(limit_.rows());
  apply<T>(limit_, current, std::span<T>(samples), context, &LimitWeight::position);
  return samples;
}

template <class T>
std::vector<T> LimitSurface::to_level(std::span<const T> values, std::size_t level) const {
  std::vector<T> current(limit_.columns, detail::zero<T>());
  add_transposed<T>(limit_, values, current, &LimitWeight::position);
  for (std::size_t step = steps_.size(); step-- > level;) current = coarsen_values<T>(steps_[step], current);
  return current;
}

}  // namespace gpsrecon::internal
