// Tangents and second derivatives: Preiner et al. 2019, appendix B (the last line for μ_uu); limit evaluation after
// Stam 1998 and 1999.

#include <gpsrecon/gps/evaluate.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate_data.h>
#include <Eigen/Geometry>
#include <cmath>

namespace gpsrecon {

using namespace internal;
namespace {

/// Below this sine of the angle between the two tangents they are taken for parallel.
constexpr double parallel_tangents = 1e-9;

/// Zero where the tangents do not span a plane.
Vec3 unit_normal(const Vec3& u, const Vec3& v) {
  const Vec3 n = u.cross(v);
  const double length = n.norm();
  return length > parallel_tangents * u.norm() * v.norm() ? Vec3(n / length) : Vec3::Zero();
}

/// [q̂] μ of a derivative of q
Vec3 residual(const DualPoint& derivative, const Vec3& mean) {
  return linear_part(derivative) - quadratic_part(derivative) * mean;
}

SurfacePoint to_space(const Jet<DualPoint>& q, const Normalization& normal_form) {
  const DualMap map(q.value);
  const auto solve = [&](const Vec3& x) { return map.covariance_times(x); };
  const auto moved = [&](const DualPoint& derivative, const Vec3& by) { return Vec3(quadratic_part(derivative) * by); };
  SurfacePoint p;
  p.position = map.mean() + normal_form.center;
  p.u = map.tangent(q.u);
  p.v = map.tangent(q.v);
  p.uu = solve(residual(q.uu, map.mean()) - 2 * moved(q.u, p.u));
  p.uv = solve(residual(q.uv, map.mean()) - moved(q.u, p.v) - moved(q.v, p.u));
  p.vv = solve(residual(q.vv, map.mean()) - 2 * moved(q.v, p.v));
  p.normal = unit_normal(p.u, p.v);
  p.covariance = normal_form.scale * map.covariance();
  return p;
}

/// The curvature tensor Σ k d dᵀ.
Mat3 tensor(const Curvature& c) {
  return c.k1 * c.direction1 * c.direction1.transpose() + c.k2 * c.direction2 * c.direction2.transpose();
}

/// From the symmetric matrix (a b; b c) of the tensor in an orthonormal basis of the tangent plane.
Curvature principal(double a, double b, double c, const Vec3& x, const Vec3& y) {
  Curvature result;
  result.mean = 0.5 * (a + c);
  result.gaussian = a * c - b * b;
  const double half = std::hypot(0.5 * (a - c), b);
  result.k1 = result.mean + half;
  result.k2 = result.mean - half;
  const double angle = 0.5 * std::atan2(2 * b, a - c);
  result.direction1 = std::cos(angle) * x + std::sin(angle) * y;
  result.direction2 = std::cos(angle) * y - std::sin(angle) * x;
  return result;
}

Curvature undefined_curvature() {
  Curvature c;
  c.exact = false;
  return c;
}

}  // namespace

FundamentalForms fundamental_forms(const SurfacePoint& p) {
  return {p.u.dot(p.u), p.u.dot(p.v), p.v.dot(p.v), p.normal.dot(p.uu), p.normal.dot(p.uv), p.normal.dot(p.vv)};
}

Curvature curvature(const SurfacePoint& p) {
  const Vec3 n = unit_normal(p.u, p.v);
  if (n.isZero(0)) return undefined_curvature();
  // In the orthonormal basis x, y with u = ux x, v = vx x + vy y the second form becomes J⁻ᵀ II J⁻¹.
  const double ux = p.u.norm();
  const Vec3 x = p.u / ux, y = n.cross(x);
  const double vx = p.v.dot(x), vy = p.v.dot(y);
  const double L = -n.dot(p.uu) / ux / ux, M = -n.dot(p.uv) / ux, N = -n.dot(p.vv);
  const double a = L, b = (M - vx * L) / vy, c = (N - 2 * vx * M + vx * vx * L) / vy / vy;
  if (!std::isfinite(a + b + c)) return undefined_curvature();
  Curvature result = principal(a, b, c, x, y);
  result.exact = !p.extraordinary;
  return result;
}

Normalization internal::normalization(const Mixture& control) {
  if (control.empty()) return {};
  const Box3 box = bounding_box(control.means);
  std::vector<double> traces(control.size());
  for (std::size_t i = 0; i < traces.size(); ++i) traces[i] = control.covariances[i].trace();
  return {box.center(), median(traces)};
}

std::vector<DualPoint> internal::dual_points(const Mixture& control, const Normalization& normal_form,
                                             const RunContext& context) {
  std::vector<DualPoint> dual(control.size());
  parallel_for(control.size(), context,
               [&](std::size_t i) { dual[i] = to_dual(normal_form.apply(control.component(i))); });
  return dual;
}

SurfaceEvaluator::Data::Data(const Mixture& control, const SurfaceRules& rules, const Connectivity& connectivity,
                             const RunContext& context)
    : table(connectivity, rules, context), face_count(connectivity.face_total()), normal_form(normalization(control)) {
  const std::vector<DualPoint> base = table.to_base<DualPoint>(dual_points(control, normal_form, context), context);
  points = table.to_points<DualPoint>(base, context);
  vertex_normals.assign(base.size(), Vec3::Zero());
  parallel_for(base.size(), context, [&](std::size_t v) {
    if (table.leaves_around(static_cast<Index>(v)).empty()) return;
    const auto row = [&](double LimitWeight::*part) {
      return apply_row<DualPoint>(table.base_limit().row(v), base, part);
    };
    const DualMap map(row(&LimitWeight::position));
    vertex_normals[v] = unit_normal(map.tangent(row(&LimitWeight::u)), map.tangent(row(&LimitWeight::v)));
  });
}

Jet<DualPoint> SurfaceEvaluator::Data::jet(const PatchTable::LeafPoint& leaf, PatchRow<2>& work) const {
  table.point_weights(leaf, work);
  Jet<DualPoint> jet;
  Eigen::Index k = 0;
  for (DualPoint* part : {&jet.value, &jet.u, &jet.v, &jet.uu, &jet.uv, &jet.vv}) {
    *part = apply_row<DualPoint>(work.row(), points, [k](const BasisWeight<2>& w) { return w[k]; });
    ++k;
  }
  return jet;
}

SurfacePoint SurfaceEvaluator::Data::evaluate(const SurfaceParameter& parameter, PatchRow<2>& work) const {
  const PatchTable::LeafPoint leaf = table.locate(parameter);
  SurfacePoint p = to_space(jet(leaf, work), normal_form);
  if (!table.extraordinary(leaf)) return p;
  p.extraordinary = true;
  if (const Vec3& n = vertex_normals[table.vertex_of(leaf.leaf)]; !n.isZero(0)) p.normal = n;
  return p;
}

Curvature SurfaceEvaluator::Data::curvature_at(const SurfaceParameter& parameter, PatchRow<2>& work) const {
  const PatchTable::LeafPoint leaf = table.locate(parameter);
  if (!table.extraordinary(leaf)) return curvature(evaluate(parameter, work));
  const Index vertex = table.vertex_of(leaf.leaf);
  Mat3 sum = Mat3::Zero();
  Vec3 normal = vertex_normals[vertex], fallback = Vec3::Zero();
  double count = 0;
  for (const Index other : table.leaves_around(vertex)) {
    const SurfacePoint p =
        to_space(jet({other, PatchTable::leaf_offset, PatchTable::leaf_offset, 1, 0, 0, 1}, work), normal_form);
    const Curvature c = curvature(p);
    if (!c.exact) continue;
    sum += tensor(c);
    fallback += p.normal;
    ++count;
  }
  if (normal.isZero(0)) normal = fallback.normalized();
  if (count == 0 || !normal.allFinite() || normal.isZero(0)) return undefined_curvature();
  sum /= count;
  const Vec3 x = normal.unitOrthogonal(), y = normal.cross(x);
  Curvature result = principal(x.dot(sum * x), x.dot(sum * y), y.dot(sum * y), x, y);
  result.exact = false;
  return result;
}

SurfaceEvaluator::SurfaceEvaluator(const ConnectedMesh& mesh, const RunContext& context)
    : data_(std::make_shared<const Data>(mesh.mesh.vertices, mesh.mesh.rules, mesh.connectivity, context)) {}

std::size_t SurfaceEvaluator::patch_count() const {
  return data_->table.patch_count();
}

Index SurfaceEvaluator::first_patch(std::size_t face) const {
  return data_->table.first_patch(face);
}

JetTable SurfaceEvaluator::weights(std::span<const SurfaceParameter> parameters, const RunContext& context) const {
  return data_->table.weights(parameters, context);
}

std::size_t SurfaceEvaluator::patches_of(std::size_t face) const {
  return (face + 1 < data_->face_count ? first_patch(face + 1) : patch_count()) - first_patch(face);
}

std::vector<SurfacePoint> SurfaceEvaluator::evaluate(std::span<const SurfaceParameter> parameters,
                                                     const RunContext& context) const {
  data_->table.check(parameters);
  std::vector<SurfacePoint> result(parameters.size());
  parallel_blocks(
      parameters.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        PatchRow<2> work;
        for (std::size_t i = begin; i < end; ++i) result[i] = data_->evaluate(parameters[i], work);
      },
      evaluation_block);
  return result;
}

SurfacePoint SurfaceEvaluator::evaluate(const SurfaceParameter& parameter) const {
  data_->table.check({&parameter, 1});
  PatchRow<2> work;
  return data_->evaluate(parameter, work);
}

std::vector<Curvature> SurfaceEvaluator::curvatures(std::span<const SurfaceParameter> parameters,
                                                    const RunContext& context) const {
  data_->table.check(parameters);
  std::vector<Curvature> result(parameters.size());
  parallel_blocks(
      parameters.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        PatchRow<2> work;
        for (std::size_t i = begin; i < end; ++i) result[i] = data_->curvature_at(parameters[i], work);
      },
      evaluation_block);
  return result;
}

}  // namespace gpsrecon
