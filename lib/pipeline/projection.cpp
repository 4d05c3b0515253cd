#include <gpsrecon/core/error.h>
#include <gpsrecon/pipeline/projection.h>
#include <cmath>
#include <string>

namespace gpsrecon {
namespace {

/// Without what is carried anew afterwards, so that it is not carried along.
PointCloud places_of(const PointCloud& points) {
  PointCloud places;
  places.positions = points.positions;
  places.weights = points.weights;
  places.frame = points.frame;
  return places;
}

}  // namespace

void ProjectionOptions::check() const {
  const auto fail = [](const char* field, double value) {
    throw OptionError(std::string(field) + " must be positive, or 0 for automatic, not " + std::to_string(value));
  };
  if (!(h_rel >= 0) || !std::isfinite(h_rel)) fail("h_rel", h_rel);
  if (!(sigma0_rel >= 0) || !std::isfinite(sigma0_rel)) fail("sigma0_rel", sigma0_rel);
  particles.check();
  hem.check();
  ProjectOptions with_radius = project;
  with_radius.support_radius = 1;
  with_radius.check();
}

double projection_sigma0(const Scale& scale, InitialCovariance initial) {
  return 0.5 * automatic_sigma0(scale, initial);
}

PointCloud project_points(const PointCloud& points, const Scale& scale, double diagonal,
                          const ProjectionOptions& options, const RunContext& context) {
  options.check();
  const PointCloud places = places_of(points);
  ProjectOptions project = options.project;
  project.support_radius =
      options.h_rel > 0 ? options.h_rel * diagonal : automatic_support_radius(scale.spacing, scale.noise);
  project.balance = options.method == ProjectionMethod::wlop;
  PointCloud particles = choose_particles(places, options.particles, context);
  std::string onto = std::to_string(points.size()) + " points";
  if (options.method == ProjectionMethod::clop) {
    HemOptions hem = options.hem;
    hem.sigma0 = options.sigma0_rel > 0 ? options.sigma0_rel * diagonal : projection_sigma0(scale, hem.initial);
    hem.spacing = scale.spacing;
    const Mixture mixture = build_mixture(places, hem, context);
    onto = std::to_string(mixture.size()) + " Gaussians of " + onto;
    particles = gpsrecon::project(particles, mixture, project, context);
  } else {
    particles = gpsrecon::project(particles, places, project, context);
  }
  attributes_from_nearest(particles, points, context);
  context.log(LogLevel::info, "project: " + std::to_string(particles.size()) + " particles onto " + onto +
                                  ", support radius " + std::to_string(project.support_radius / diagonal) +
                                  " of the diagonal");
  return particles;
}

}  // namespace gpsrecon
