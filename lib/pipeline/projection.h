#pragma once

#include <gpsrecon/clop/particles.h>
#include <gpsrecon/clop/project.h>
#include <gpsrecon/core/prepared_cloud.h>
#include <gpsrecon/hem/hem.h>
#include <array>
#include <string_view>

namespace gpsrecon {

/// What particles are drawn to.
enum class ProjectionMethod {
  clop,  ///< a mixture of the points
  wlop,  ///< the points, weighted by the inverse of their density
  lop,   ///< the points
};

constexpr std::array<std::string_view, 3> option_names(ProjectionMethod /*type*/) {
  return {"clop", "wlop", "lop"};
}

/// A projection of a cloud, from its points to particles.
struct ProjectionOptions {
  ProjectionMethod method = ProjectionMethod::clop;
  Length support_radius = {};
  ParticleOptions particles;
  /// Its `support_radius` and `balance` follow from those above and are refused.
  ProjectOptions project;
  /// Of the mixture; its automatic kernel width is projection_sigma0() here.
  HemOptions hem{.flat_levels = 0, .balance = true};

  static OptionTable fields() {
    using O = ProjectionOptions;
    return {
        field<&O::method>("method", "",
                          "what draws the particles: a mixture of the points, the points weighted by the inverse of "
                          "their density, or the points"),
        field<&O::support_radius>("support-radius", "> 0",
                                  "support radius of the kernels; auto = from spacing and noise")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const;
};

/// The kernel width that suits the first Gaussians of a mixture that particles are drawn to: half of that for surfaces
/// (automatic_sigma0). The sheet may be several Gaussians thick here, and what the kernel smears across it weakens the
/// attraction.
double projection_sigma0(const Scale& scale, InitialCovariance initial);

/// Particles of a cloud (clop/particles.h), projected to its local medians (clop/project.h). In the frame of the cloud,
/// with colours, scalars and sensors of the points nearest to where they end, without normals. Throws OptionError,
/// NoSurfaceError, Cancelled.
PointCloud project_points(const PreparedCloud& cloud, const ProjectionOptions& options = {},
                          const RunContext& context = {});

}  // namespace gpsrecon
