#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate_data.h>
#include <gpsrecon/gps/face_normals.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/quad_step.h>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numeric>

namespace gpsrecon {
namespace {

/// Below this sine of the angle between the two tangents they are taken for parallel.
constexpr double parallel_tangents = 1e-9;

void check_size(std::size_t faces, int levels) {
  // The longest index runs over the entries of the limit table: fewer than twelve per face.
  if (std::ldexp(12.0 * static_cast<double>(faces), 2 * levels) >= std::numeric_limits<Index>::max())
    throw OptionError("levels: " + std::to_string(levels) + " refinements of " + std::to_string(faces) +
                      " faces are more than can be indexed");
}

std::vector<DualPoint> refine_dual(const Mixture& control, const Normalization& normal_form,
                                   const std::vector<StencilTable>& steps, const RunContext& context) {
  std::vector<DualPoint> dual(control.size());
  parallel_for(control.size(), context,
               [&](std::size_t i) { dual[i] = to_dual(normal_form.apply(control.component(i))); });
  for (const StencilTable& step : steps) {
    std::vector<DualPoint> refined(step.rows());
    apply<DualPoint>(step, dual, refined, context);
    dual.swap(refined);
  }
  return dual;
}

struct LimitPoint {
  DualPoint position = DualPoint::Zero(), u = DualPoint::Zero(), v = DualPoint::Zero();
};

LimitPoint limit_point(const LimitTable& table, std::size_t r, const std::vector<DualPoint>& dual) {
  const auto indices = table.row_indices(r);
  const auto weights = table.row_weights(r);
  LimitPoint p;
  for (std::size_t j = 0; j < indices.size(); ++j) {
    const DualPoint& q = dual[indices[j]];
    p.position += weights[j].position * q;
    p.u += weights[j].u * q;
    p.v += weights[j].v * q;
  }
  return p;
}

/// Zero where the tangents do not span a plane.
Vec3 unit_normal(const Vec3& u, const Vec3& v) {
  const Vec3 n = u.cross(v);
  const double length = n.norm();
  return length > parallel_tangents * u.norm() * v.norm() ? Vec3(n / length) : Vec3::Zero();
}

}  // namespace

LimitSurface::LimitSurface(const FaceList& faces, std::size_t control_count, int levels, const EvaluateOptions& rules,
                           const RunContext& context)
    : control_count_(control_count) {
  if (levels < 0) throw OptionError("levels: " + std::to_string(levels) + " is negative");
  if (rules.scheme == Scheme::catmull_clark) {
    if (levels == 0 && !faces.all_of_size(4))
      throw OptionError("levels must be at least 1 for Catmull-Clark surfaces with faces of other than four corners");
    check_size(faces.corners.size() / 3, levels);
    // The rows of the first step list all corners of the faces around.
    double entries = 0;
    for (std::size_t f = 0; f < faces.size(); ++f) entries += 3 * std::pow(static_cast<double>(faces[f].size()), 2);
    if (levels > 0 && entries >= std::numeric_limits<Index>::max())
      throw OptionError("Catmull-Clark refinement of faces with so many corners is more than can be indexed");
    PolygonEdges topology = polygon_edges(faces, control_count);
    for (int level = 0; level < levels; ++level) {
      QuadStep step = catmull_clark_step(topology, rules.corners);
      steps_.push_back(std::move(step.stencils));
      topology = std::move(step.edges);
    }
    limit_ = quad_limit_table(topology, rules.corners);
    faces_.corners = std::move(topology.corners);
    faces_.offsets.resize(faces_.corners.size() / 4 + 1);
    for (std::size_t f = 0; f < faces_.offsets.size(); ++f) faces_.offsets[f] = static_cast<std::uint32_t>(4 * f);
    return;
  }
  check_size(faces.size(), levels);
  TriangleConnectivity topology = triangle_connectivity(faces, control_count);
  for (int level = 0; level < levels; ++level) {
    steps_.push_back(loop_stencils(topology, rules.weights, rules.corners, context));
    topology = refine(topology, context);
  }
  limit_ = limit_table(topology, rules.weights, rules.corners, context);
  faces_ = take_faces(std::move(topology));
}

SurfaceSamples LimitSurface::evaluate(const Mixture& control, bool limit, const RunContext& context,
                                      bool covariances) const {
  if (control.size() != control_count_)
    throw InvariantError("limit surface: " + std::to_string(control.size()) + " Gaussians for " +
                         std::to_string(control_count_) + " control vertices");
  const Normalization normal_form = normalization(control);
  const std::vector<DualPoint> dual = refine_dual(control, normal_form, steps_, context);
  const double kernel_variance = control.sigma0 * control.sigma0;
  const auto describe = [&](SurfaceSamples& samples, std::size_t i, const DualMap& map) {
    const Vec3& n = samples.normals[i];
    samples.spread[i] = normal_form.scale * map.covariance_times(n);
    samples.sigma[i] = std::sqrt(std::max(0.0, n.dot(samples.spread[i]) - kernel_variance));
  };

  SurfaceSamples samples;
  samples.positions.resize(sample_count());
  samples.normals.resize(sample_count());
  samples.sigma.resize(sample_count());
  samples.spread.resize(sample_count());
  if (covariances) samples.covariances.resize(sample_count());
  parallel_for(sample_count(), context, [&](std::size_t i) {
    const LimitPoint q = limit_point(limit_, i, dual);
    const DualMap limit_map(q.position);
    const DualMap map = limit ? limit_map : DualMap(dual[i]);
    samples.positions[i] = map.mean() + normal_form.center;
    if (covariances) samples.covariances[i] = normal_form.scale * map.covariance();
    samples.normals[i] = unit_normal(limit_map.tangent(q.u), limit_map.tangent(q.v));
    describe(samples, i, map);
  });

  for (const Index i : complete_normals(faces_, samples.positions, samples.normals)) {
    const DualMap map(limit ? limit_point(limit_, i, dual).position : dual[i]);
    if (samples.normals[i].isZero(0)) samples.normals[i] = eigen_decomposition(map.covariance()).vectors.col(0);
    describe(samples, i, map);
  }
  return samples;
}

std::vector<Index> LimitSurface::control_of_samples() const {
  std::vector<Index> control(control_count_);
  std::iota(control.begin(), control.end(), Index{0});
  for (const StencilTable& step : steps_) {
    // Edges come after vertices; their rows begin with their two ends.
    for (std::size_t r = step.columns; r < step.rows(); ++r) {
      const auto ends = step.row_indices(r).first(2);
      control.push_back(std::min(control[ends[0]], control[ends[1]]));
    }
  }
  return control;
}

}  // namespace gpsrecon
