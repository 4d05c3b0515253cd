#pragma once

#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/patch_table.h>

// Internal to lib/gps: what a SurfaceEvaluator holds.

namespace gpsrecon::internal {

/// How the Gaussians are normalised before they are mapped: the surface does not depend on a global factor on Σ, and
/// Σ⁻¹μ keeps the more digits the closer the means are to the origin.
struct Normalization {
  Vec3 center = Vec3::Zero();
  double scale = 1;  ///< of covariances

  Gaussian apply(const Gaussian& g) const { return {g.mean - center, g.covariance * (1 / scale)}; }
};
Normalization normalization(const Mixture& control);
/// Images of the normalised Gaussians in R⁹.
std::vector<DualPoint> dual_points(const Mixture& control, const Normalization& normal_form, const RunContext& context);

/// Evaluations per block of work: each costs about a microsecond.
inline constexpr std::size_t evaluation_block = 512;

/// A value with its derivatives by the two parameters.
template <class T>
struct Jet {
  T value, u, v, uu, uv, vv;
};

}  // namespace gpsrecon::internal

namespace gpsrecon {

struct SurfaceEvaluator::Data {
  Data(const Mixture& control, const SurfaceRules& rules, const Connectivity& connectivity, const RunContext& context);

  Vec3 position(const SurfaceParameter& parameter, internal::PatchRow<0>& work) const {
    table.point_weights(table.locate(parameter), work);
    return internal::DualMap(internal::apply_row<internal::DualPoint>(work.row(), points)).mean() + normal_form.center;
  }
  internal::Jet<internal::DualPoint> jet(const internal::PatchTable::LeafPoint& leaf,
                                         internal::PatchRow<2>& work) const;
  SurfacePoint evaluate(const SurfaceParameter& parameter, internal::PatchRow<2>& work) const;
  Curvature curvature_at(const SurfaceParameter& parameter, internal::PatchRow<2>& work) const;

  internal::PatchTable table;
  std::size_t face_count;
  internal::Normalization normal_form;
  std::vector<internal::DualPoint> points;
  std::vector<Vec3> vertex_normals;  ///< of the base mesh: at irregular vertices, zero where there is no tangent plane
};

}  // namespace gpsrecon
