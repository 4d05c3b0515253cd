#pragma once

#include <gpsrecon/clop/particles.h>
#include <gpsrecon/clop/project.h>
#include <gpsrecon/hem/hem.h>
#include <gpsrecon/hem/scale.h>

namespace gpsrecon {

/// What particles are drawn to.
enum class ProjectionMethod {
  clop,  ///< a mixture of the points
  wlop,  ///< the points, weighted by the inverse of their density
  lop,   ///< the points
};

/// A projection of a cloud, from its points to particles.
struct ProjectionOptions {
  ProjectionMethod method = ProjectionMethod::clop;
  /// Support radius h as a share of the diagonal. Range: > 0; 0 = automatic, from spacing and noise.
  double h_rel = 0;
  ParticleOptions particles;
  /// `support_radius` and `balance` are not used: see h_rel, method and hem.
  ProjectOptions project;
  /// Kernel width of the mixture as a share of the diagonal. Range: > 0; 0 = automatic, projection_sigma0().
  double sigma0_rel = 0;
  /// Of the mixture. `sigma0` and `spacing` are not used.
  HemOptions hem{.initial = InitialCovariance::local, .balance = true};

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// The kernel width that suits the first Gaussians of a mixture that particles are drawn to: half of that for surfaces
/// (automatic_sigma0). The sheet may be several Gaussians thick here, and what the kernel smears across it weakens the
/// attraction.
double projection_sigma0(const Scale& scale, InitialCovariance initial);

/// Particles of a cloud of this scale and bounding-box diagonal (clop/particles.h), projected to its local medians
/// (clop/project.h). In the frame of the cloud, with colours, scalars and sensors of the points nearest to where they
/// end, without normals. Throws OptionError, NoSurfaceError, Cancelled.
PointCloud project_points(const PointCloud& points, const Scale& scale, double diagonal,
                          const ProjectionOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
