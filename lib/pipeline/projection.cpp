#include <gpsrecon/pipeline/projection.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/estimate_scale.h>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

/// Without what is carried anew afterwards, so that it is not carried along.
PointCloud without_attributes(const PointCloud& points) {
  PointCloud bare;
  bare.positions = points.positions;
  bare.weights = points.weights;
  bare.frame = points.frame;
  return bare;
}

}  // namespace

void ProjectionOptions::check() const {
  check_fields(*this);
  particles.check();
  hem.check();
  project.check();
  if (project.support_radius != 0) throw OptionError("project.support_radius: support_radius is the one to set");
  if (!project.balance) throw OptionError("project.balance: the method says whether points are balanced");
}

double projection_sigma0(const Scale& scale, InitialCovariance initial) {
  // Attraction averages over the caps of the support radius, so that their curvature counts as well.
  return 0.5 * (initial == InitialCovariance::local ? local_width(scale.spacing, scale.thickness)
                                                    : isotropic_width(scale.spacing, scale.thickness));
}

PointCloud project_points(const PreparedCloud& cloud, const ProjectionOptions& options, const RunContext& context) {
  options.check();
  const PointCloud& points = cloud.cloud;
  const Scale& scale = cloud.scale;
  const PointCloud bare = without_attributes(points);
  const double unit = points.frame.scale();
  const LengthScale lengths = cloud.lengths();
  ProjectOptions project = options.project;
  project.support_radius = options.support_radius.resolve(lengths, "support-radius",
                                                          automatic_support_radius(scale.spacing, scale.thickness));
  project.balance = options.method == ProjectionMethod::wlop;
  PointCloud particles = choose_particles(bare, options.particles, context);
  std::string onto = std::to_string(points.size()) + " points";
  if (options.method == ProjectionMethod::clop) {
    HemOptions hem = options.hem;
    const double spacing = hem.spacing.resolve(lengths, "spacing", scale.spacing);
    const double sigma0 = hem.sigma0.resolve(lengths, "sigma0", projection_sigma0(scale, hem.initial) / hem.detail);
    hem.detail = 1;
    hem.spacing = Length::scene(spacing * unit);
    hem.sigma0 = Length::scene(sigma0 * unit);
    const Mixture mixture = build_mixture(bare, hem, context);
    onto = std::to_string(mixture.size()) + " Gaussians of " + onto;
    particles = gpsrecon::project(particles, mixture, project, context);
  } else {
    particles = gpsrecon::project(particles, bare, project, context);
  }
  attributes_from_nearest(particles, points, context);
  context.log(LogLevel::info, "project: " + std::to_string(particles.size()) + " particles onto " + onto +
                                  ", support radius " + std::to_string(project.support_radius / cloud.diagonal) +
                                  " of the diagonal");
  return particles;
}

}  // namespace gpsrecon
