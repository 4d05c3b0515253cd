// Preiner et al. 2019, section 4, Eq. 11-13.

#include <gpsrecon/gps/subdivide.h>

#include <gpsrecon/core/attributes.h>
#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/gps/adaptive.h>
#include <gpsrecon/gps/attributes.h>
#include <gpsrecon/gps/evaluate_data.h>
#include <gpsrecon/gps/face_normals.h>
#include <gpsrecon/gps/refined_parameters.h>
#include <gpsrecon/gps/refinement_levels.h>
#include <gpsrecon/gps/surface_samples.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace gpsrecon {

using namespace internal;
namespace {

/// Control edges are halved this often by a tolerance, at most: three times more than by the largest number of levels.
constexpr int max_halvings = 11;

void add_scalar(Mesh& mesh, const char* name, std::vector<double> values) {
  mesh.scalars.push_back({name, std::move(values), ScalarKind::quantity});
}

/// Columns in world units. Where a vertex has no parameter it has no curvature.
void add_curvatures(const SurfaceEvaluator& surface, const std::vector<SurfaceParameter>& parameters, Mesh& mesh,
                    const RunContext& context) {
  std::vector<SurfaceParameter> on_surface;
  for (const SurfaceParameter& parameter : parameters)
    if (parameter.patch != no_index) on_surface.push_back(parameter);
  const std::vector<Curvature> known = surface.curvatures(on_surface, context);
  std::vector<Curvature> all(parameters.size());
  for (std::size_t v = 0, next = 0; v < parameters.size(); ++v) {
    if (parameters[v].patch != no_index)
      all[v] = known[next++];
    else
      all[v].exact = false;
  }
  const auto column = [&](const auto& value) {
    std::vector<double> values(all.size());
    for (std::size_t v = 0; v < all.size(); ++v) values[v] = value(all[v]);
    return values;
  };
  const double unit = 1 / mesh.frame.scale();
  add_scalar(mesh, "mean_curvature", column([=](const Curvature& c) { return unit * c.mean; }));
  add_scalar(mesh, "gaussian_curvature", column([=](const Curvature& c) { return unit * unit * c.gaussian; }));
  add_scalar(mesh, "k1", column([=](const Curvature& c) { return unit * c.k1; }));
  add_scalar(mesh, "k2", column([=](const Curvature& c) { return unit * c.k2; }));
  const std::array<std::array<const char*, 3>, 2> names{{{"k1x", "k1y", "k1z"}, {"k2x", "k2y", "k2z"}}};
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      add_scalar(mesh, names[k][axis], column([=](const Curvature& c) {
                   return (k == 0 ? c.direction1 : c.direction2)[static_cast<Eigen::Index>(axis)];
                 }));
  add_scalar(mesh, "curvature_exact", column([](const Curvature& c) { return c.exact ? 1.0 : 0.0; }));
  const auto not_exact = std::count_if(all.begin(), all.end(), [](const Curvature& c) { return !c.exact; });
  context.log(LogLevel::info, "curvature: exact at " +
                                  std::to_string(all.size() - static_cast<std::size_t>(not_exact)) +
                                  " vertices, taken around " + std::to_string(not_exact) + " irregular ones");
}

Mesh subdivide_to_tolerance(const ConnectedMesh& connected, const SubdivideOptions& options,
                            const RunContext& context) {
  const CovMesh& mesh = connected.mesh;
  const double tolerance = options.tolerance->resolve({.diagonal = bounding_box_diagonal(mesh.vertices.means),
                                                       .spacing = mesh.vertices.spacing,
                                                       .scene_to_local = 1 / mesh.vertices.frame.scale()},
                                                      "tolerance");
  const SurfaceEvaluator surface(connected, context);
  Tessellation result = tessellate(surface, connected, tolerance, max_halvings, context);
  context.progress("subdivide", 0.8);
  if (result.unresolved > 0)
    context.warn("tolerance: " + std::to_string(result.unresolved) +
                 " triangles are farther from the surface, but edges have been halved " + std::to_string(max_halvings) +
                 " times");
  Mesh refined;
  refined.faces = std::move(result.faces);
  refined.positions = std::move(result.positions);
  refined.normals.assign(refined.positions.size(), Vec3::Zero());
  refined.sigma.resize(refined.positions.size());
  refined.frame = mesh.vertices.frame;
  std::vector<Sym3> covariances(refined.positions.size());
  parallel_blocks(
      refined.positions.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        PatchRow<2> work;
        for (std::size_t v = begin; v < end; ++v) {
          if (result.parameters[v].patch == no_index) {
            covariances[v] = mesh.vertices.covariances[v];
            continue;
          }
          const SurfacePoint p = surface.data().evaluate(result.parameters[v], work);
          refined.normals[v] = p.normal;
          covariances[v] = p.covariance;
        }
      },
      evaluation_block);
  // Where not even the faces around tell, the thin axis of the Gaussian does.
  for (const Index v : complete_normals(refined.faces, refined.positions, refined.normals, context))
    if (refined.normals[v].isZero(0)) refined.normals[v] = eigen_decomposition(covariances[v]).vectors.col(0);
  const double kernel = mesh.vertices.sigma0 * mesh.vertices.sigma0;
  for (std::size_t v = 0; v < refined.sigma.size(); ++v)
    refined.sigma[v] = std::sqrt(std::max(0.0, covariances[v].quadratic_form(refined.normals[v]) - kernel));
  if (options.attributes) interpolate_attributes(surface, result.parameters, mesh.vertices, refined, context);
  if (options.curvature) add_curvatures(surface, result.parameters, refined, context);
  if (options.covariances) refined.covariances = std::move(covariances);
  return refined;
}

template <class Scheme>
Mesh subdivide_uniformly(const ConnectedMesh& connected, const SubdivideOptions& options, const RunContext& context) {
  const CovMesh& mesh = connected.mesh;
  const int level = options.levels ? *options.levels : automatic_level(connected);
  check_levels(connected.connectivity, level, mesh.rules);
  const RefinementLevels<Scheme> levels(connected.connectivity, level, mesh.rules, context);
  context.progress("subdivide", 0.3);
  Mesh refined;
  refined.faces = levels.faces(context);
  const Normalization normal_form = normalization(mesh.vertices);
  SurfaceSamples samples = surface_samples(
      levels.limit(), levels.refine_to_last(dual_points(mesh.vertices, normal_form, context), context), normal_form,
      mesh.vertices.sigma0, refined.faces, {.limit = options.limit, .covariances = options.covariances}, context);
  refined.positions = std::move(samples.positions);
  refined.normals = std::move(samples.normals);
  refined.sigma = std::move(samples.sigma);
  refined.covariances = std::move(samples.covariances);
  refined.frame = mesh.vertices.frame;
  if (options.attributes) interpolate_attributes(levels, mesh.vertices, refined, context);
  if (options.curvature) {
    const std::vector<SurfaceParameter> parameters =
        refined_parameters(mesh.faces, refined.faces, refined.positions.size(), level, mesh.rules.scheme);
    add_curvatures(SurfaceEvaluator(connected, context), parameters, refined, context);
  }
  return refined;
}

}  // namespace

void SubdivideOptions::check() const {
  check_fields(*this);
  if (tolerance && levels) throw OptionError("tolerance and levels contradict each other");
  if (tolerance && !limit) throw OptionError("tolerance needs limit");
}

Mesh subdivide(const ConnectedMesh& mesh, const SubdivideOptions& options, const RunContext& context) {
  options.check();
  context.progress("subdivide", 0);
  const auto refine_mesh = options.tolerance                        ? subdivide_to_tolerance
                           : mesh.mesh.rules.scheme == Scheme::loop ? subdivide_uniformly<LoopScheme>
                                                                    : subdivide_uniformly<CatmullClarkScheme>;
  Mesh refined = refine_mesh(mesh, options, context);
  context.log(LogLevel::info, "subdivide: " + std::to_string(refined.faces.size()) + " faces");
  context.progress("subdivide", 1);
  return refined;
}

Mesh subdivide(const ConnectedMesh& mesh, const PreparedCloud& cloud, const SubdivideOptions& options,
               const RunContext& context) {
  const PointCloud& points = cloud.cloud;
  const double unit = points.frame.scale();
  SubdivideOptions known = options;
  known.attributes = options.attributes && !has_attributes(points);
  if (options.tolerance)
    known.tolerance = Length::scene(options.tolerance->resolve(
        {.diagonal = cloud.diagonal * unit, .spacing = cloud.scale.spacing * unit}, "tolerance"));
  Mesh refined = subdivide(mesh, known, context);
  if (options.attributes) {
    if (points.frame == refined.frame)
      attributes_from_points(refined, points, context);
    else
      attributes_from_points(refined, in_frame(points, refined.frame), context);
  }
  return refined;
}

int automatic_level(const ConnectedMesh& mesh) {
  // One level more would quadruple the mesh, and the memory and time for its report, for an accuracy that no longer
  // changes by more than a few per cent. A Catmull-Clark surface shows its quadrilaterals from the first level on.
  const int lowest = mesh.mesh.rules.scheme == Scheme::catmull_clark ? 1 : 0;
  return std::max(level_for_edge_length(mesh, 1.5 * mesh.mesh.vertices.spacing), lowest);
}

int level_for_edge_length(const ConnectedMesh& mesh, double target_edge, int max_level) {
  const Connectivity& topology = mesh.connectivity;
  const std::vector<Vec3>& means = mesh.mesh.vertices.means;
  if (topology.edge_count() == 0) return 0;
  double sum = 0;
  for (const Index h : topology.edge_start) sum += (means[topology.target(h)] - means[topology.source(h)]).norm();
  // Every level halves the edges.
  double mean_edge = sum / static_cast<double>(topology.edge_count());
  int level = 0;
  while (level < max_level && !(mean_edge <= target_edge)) {
    mean_edge /= 2;
    ++level;
  }
  return level;
}

}  // namespace gpsrecon
