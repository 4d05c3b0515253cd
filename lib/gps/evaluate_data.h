#pragma once

#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/patch_table.h>

// Internal to lib/gps: what a SurfaceEvaluator holds.

namespace gpsrecon {

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

struct SurfaceEvaluator::Data {
  Data(const CovMesh& mesh, const RunContext& context);

  Vec3 position(const SurfaceParameter& place, PatchTable::Workspace<DualPoint>& work) const {
    return DualMap(table.value<DualPoint>(points, place, work)).mean() + normal_form.center;
  }
  SurfacePoint evaluate(const SurfaceParameter& place, PatchTable::Workspace<DualPoint>& work) const;
  Curvature curvature_at(const SurfaceParameter& place, PatchTable::Workspace<DualPoint>& work) const;

  PatchTable table;
  FaceList face_sizes;
  Normalization normal_form;
  std::vector<DualPoint> points;
  std::vector<Vec3> vertex_normals;  ///< of the base mesh: at irregular vertices, zero where there is no tangent plane
};

}  // namespace gpsrecon
