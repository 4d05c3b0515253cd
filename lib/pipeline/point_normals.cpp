#include <gpsrecon/pipeline/point_normals.h>

#include <gpsrecon/core/clean.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <Eigen/Geometry>
#include <cmath>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

/// Normals at the distinct points, from those that are not isolated.
std::vector<Vec3> estimate(const PointCloud& distinct, PreparedCloud& used, const PointNormalsOptions& options,
                           const NormalSources& sources, const RunContext& context) {
  PointCloud& cloud = used.cloud;
  NormalOptions normals = options.normals;
  const double given_h = options.support_radius.resolve(used.lengths(), "support-radius");
  normals.h = given_h;
  if (sources.mixture == nullptr || options.method != NormalMethod::csw)
    normals = resolve(normals, cloud.positions, context);
  if (options.method == NormalMethod::pca) return pca_normals(distinct.positions, cloud.positions, normals, context);

  if (options.method == NormalMethod::csw && sources.mixture != nullptr) {
    const Frame& frame = sources.mixture->frame;
    normals.h = std::ldexp(normals.h, cloud.frame.exponent - frame.exponent);
    return csw_normals(in_frame(distinct.positions, distinct.frame, frame), *sources.mixture, normals, context);
  }
  cloud.normals = pca_normals(cloud.positions, cloud.positions, normals, context);
  context.progress("normals", 0.3);
  normals.h = given_h;  // an automatic one depends on the position
  if (options.method == NormalMethod::weiszfeld) return weiszfeld_normals(distinct.positions, cloud, normals, context);
  HemOptions reduction = options.mixture;
  reduction.normals = true;
  return csw_normals(distinct.positions, build_mixture(used, reduction, context).mixture, normals, context);
}

std::vector<Vec3> sides_of_surface(const PointCloud& distinct, const Mesh& surface, const RunContext& context) {
  Mesh local = surface;
  local.positions = in_frame(std::move(local.positions), surface.frame, distinct.frame);
  std::vector<Vec3> sides;
  sides.reserve(distinct.size());
  for (const ClosestPoint& closest : SurfaceDistance(local, context).distances(distinct.positions, context))
    sides.push_back(area_vector(local.positions, local.faces[closest.face]));
  return sides;
}

std::vector<Vec3> ways_to_sensor(const PointCloud& distinct, const std::optional<Vec3>& sensor) {
  std::vector<Vec3> ways(distinct.size());
  const Vec3 at = sensor ? distinct.frame.to_local(*sensor) : Vec3::Zero();
  for (std::size_t i = 0; i < ways.size(); ++i) ways[i] = (sensor ? at : distinct.sensors[i]) - distinct.positions[i];
  return ways;
}

NormalOrientation orientation_at_hand(const PointCloud& world, const PointNormalsOptions& options,
                                      const NormalSources& sources) {
  const bool has_sensor = options.sensor || !world.sensors.empty();
  if (options.orientation == NormalOrientation::automatic)
    return sources.surface != nullptr ? NormalOrientation::surface
           : has_sensor               ? NormalOrientation::sensor
                                      : NormalOrientation::neighbors;
  if (options.orientation == NormalOrientation::surface && sources.surface == nullptr)
    throw OptionError("orientation by the surface needs a surface");
  if (options.orientation == NormalOrientation::sensor && !has_sensor)
    throw OptionError("orientation by the sensor needs its position, or columns sx sy sz of the points");
  return options.orientation;
}

void orient(std::vector<Vec3>& normals, const PointCloud& distinct, NormalOrientation orientation,
            const PointNormalsOptions& options, const NormalSources& sources, const RunContext& context) {
  switch (orientation) {
    case NormalOrientation::surface:
      return orient_along(normals, sides_of_surface(distinct, *sources.surface, context));
    case NormalOrientation::sensor:
      return orient_along(normals, ways_to_sensor(distinct, options.sensor));
    case NormalOrientation::neighbors: {
      const std::size_t parts = orient_by_propagation(normals, distinct.positions, options.propagation, context);
      context.log(LogLevel::info, "orientation: " + count_of(parts, "connected part") + ", each turned outward");
      return;
    }
    case NormalOrientation::automatic:
    case NormalOrientation::none:
      return;
  }
}

/// All finite points of the input, each with the normal of the distinct point it is equal to.
PointCloud with_normals(const PointCloud& world, const CleanCloud& clean, const std::vector<Vec3>& normals) {
  std::vector<Index> distinct_of(world.size(), no_index);
  for (std::size_t k = 0; k < clean.source.size(); ++k) distinct_of[clean.source[k]] = static_cast<Index>(k);
  std::vector<Index> finite;
  for (std::size_t i = 0; i < world.size(); ++i)
    if (world.positions[i].allFinite()) finite.push_back(static_cast<Index>(i));
  if (clean.duplicates > 0) {
    const Neighbors index(clean.cloud.positions);
    std::vector<Neighbor> near;
    for (const Index i : finite) {
      if (distinct_of[i] != no_index) continue;
      index.nearest(clean.cloud.frame.to_local(world.positions[i]), 1, near);
      distinct_of[i] = near.front().index;
    }
  }
  PointCloud result = select(world, finite);
  result.normals.resize(finite.size());
  for (std::size_t k = 0; k < finite.size(); ++k) result.normals[k] = normals[distinct_of[finite[k]]];
  return result;
}

}  // namespace

void PointNormalsOptions::check() const {
  normals.check();
  propagation.check();
  scale.check();
  mixture.check();
  check_fields(*this);
  if (normals.h != 0) throw OptionError("normals.h: support_radius is the one to set");
}

PointCloud point_normals(const PointCloud& world, const PointNormalsOptions& options, const NormalSources& sources,
                         const RunContext& context) {
  options.check();
  const NormalOrientation orientation = orientation_at_hand(world, options, sources);
  if (sources.surface != nullptr && sources.surface->faces.empty()) throw InputError("the surface holds no faces");
  const CleanCloud all = clean(world, context);
  PreparedCloud used = prepare(world, options.scale, context);
  std::vector<Vec3> normals = estimate(all.cloud, used, options, sources, context);
  context.progress("normals", 0.8);
  orient(normals, all.cloud, orientation, options, sources, context);
  context.progress("normals", 1);
  return with_normals(world, all, normals);
}

}  // namespace gpsrecon
