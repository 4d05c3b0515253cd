// The gyroid: Schoen 1970; a net of its samples: surface nets, Gibson 1998.

#include "gyroid.h"

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "shape_meshing.h"

namespace gpsrecon::internal {
namespace {

constexpr double sample_cell = 0.12;         ///< of the net of samples; they lie no farther apart than about this
constexpr double cover = 1.5 * sample_cell;  ///< every point of the surface has a sample as near

}  // namespace

struct Gyroid::Value {
  double f;
  Vec3 gradient;
  Mat3 hessian;
};

double Gyroid::value(const Vec3& p) const {
  const double a =
      (std::sin(p.x()) * std::cos(p.y()) + std::sin(p.y()) * std::cos(p.z()) + std::sin(p.z()) * std::cos(p.x())) /
      std::numbers::sqrt3;
  const double b = (p.squaredNorm() - ball_radius_ * ball_radius_) / (2 * ball_radius_);
  return (a + b + std::hypot(a - b, rounding_)) / 2;
}

Gyroid::Value Gyroid::evaluate(const Vec3& p) const {
  const double sx = std::sin(p.x()), sy = std::sin(p.y()), sz = std::sin(p.z());
  const double cx = std::cos(p.x()), cy = std::cos(p.y()), cz = std::cos(p.z());
  constexpr double scale = 1 / std::numbers::sqrt3;
  const double a = scale * (sx * cy + sy * cz + sz * cx);
  const Vec3 da = scale * Vec3(cx * cy - sz * sx, cy * cz - sx * sy, cz * cx - sy * sz);
  Mat3 dda;
  dda << -sx * cy - sz * cx, -cx * sy, -cz * sx, -cx * sy, -sx * cy - sy * cz, -cy * sz, -cz * sx, -cy * sz,
      -sy * cz - sz * cx;
  const double b = (p.squaredNorm() - ball_radius_ * ball_radius_) / (2 * ball_radius_);
  const Vec3 db = p / ball_radius_;
  const double s = std::hypot(a - b, rounding_), share = (1 + (a - b) / s) / 2;
  const Vec3 difference = da - db;
  return {(a + b + s) / 2, share * da + (1 - share) * db,
          share * scale * dda + (1 - share) / ball_radius_ * Mat3::Identity() +
              rounding_ * rounding_ / (2 * s * s * s) * difference * difference.transpose()};
}

/// From a point nearby to the surface, along the gradient.
Vec3 Gyroid::on_surface(Vec3 p) const {
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Value v = evaluate(p);
    const Vec3 move = -v.f / v.gradient.squaredNorm() * v.gradient;
    p += move;
    if (move.squaredNorm() < 1e-30) break;
  }
  return p;
}

Gyroid::Gyroid(double ball_radius, double rounding) : ball_radius_(ball_radius), rounding_(rounding), curvature_(0) {
  if (!(ball_radius > 0 && rounding > 0 && rounding < ball_radius))
    throw OptionError("a gyroid needs a rounding between 0 and its radius");
  samples_ = net(sample_cell).positions;
  if (samples_.empty()) throw OptionError("a gyroid of this size is empty");
  nearest_sample_ = std::make_unique<Neighbors>(samples_);
  Box3 box;
  for (const Vec3& sample : samples_) {
    box.extend(sample);
    const Value v = evaluate(sample);
    const Vec3 n = v.gradient.normalized();
    const Mat3 across = Mat3::Identity() - n * n.transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3> shape(across * v.hessian * across, Eigen::EigenvaluesOnly);
    curvature_ = std::max(curvature_, shape.eigenvalues().cwiseAbs().maxCoeff() / v.gradient.norm());
  }
  diagonal_ = diagonal_length(box);
}

double Gyroid::clearance(const Vec3& p) const {
  return std::abs(value(p)) / std::max(1.0, p.norm() / ball_radius_);
}

/// A stationary point of the distance from p on the surface, from a start on the surface. In the tangent plane half the
/// squared distance has the gradient r = q - p + λ∇f and the Hessian 1 + λH, with the λ that makes r tangential; where
/// that is not positive definite a step down the gradient serves.
Vec3 Gyroid::refine(const Vec3& p, const Vec3& start) const {
  Vec3 q = start;
  for (int iteration = 0; iteration < 60; ++iteration) {
    const Value v = evaluate(q);
    const Vec3& n = v.gradient;
    const double lambda = (p - q).dot(n) / n.squaredNorm();
    const Vec3 residual = q - p + lambda * n, back = -v.f / n.squaredNorm() * n;
    const Vec3 first = n.unitOrthogonal(), second = n.cross(first).normalized();
    Eigen::Matrix<double, 3, 2> tangents;
    tangents << first, second;
    const Mat3 hessian = Mat3::Identity() + lambda * v.hessian;
    const Eigen::Matrix2d reduced = tangents.transpose() * hessian * tangents;
    const bool convex = reduced.trace() > 0 && reduced.determinant() > 1e-3 * reduced.trace() * reduced.trace();
    Vec2 step = convex ? Vec2(-reduced.inverse() * (tangents.transpose() * (residual + hessian * back)))
                       : Vec2(-0.5 * tangents.transpose() * residual);
    if (const double length = step.norm(); length > sample_cell) step *= sample_cell / length;
    q += tangents * step + back;
    if (step.squaredNorm() + back.squaredNorm() < 1e-28) break;
  }
  return on_surface(q);
}

ShapePoint Gyroid::closest(const Vec3& p) const {
  std::vector<Neighbor> candidates;
  nearest_sample_->nearest(p, 1, candidates);
  // The closest point has a sample within `cover`, which the surface's curvature lifts off its tangent plane by no more
  // than `bulge`.
  const double bulge = curvature_ * cover * cover / 2;
  const auto reach = [&](double distance) { return std::hypot(distance + bulge, cover); };
  nearest_sample_->within(p, reach(candidates.front().distance), candidates);
  std::sort(candidates.begin(), candidates.end());
  Vec3 best = Vec3::Zero();
  double distance = std::numeric_limits<double>::infinity();
  std::vector<Vec3> found;
  for (const Neighbor& candidate : candidates) {
    if (candidate.distance > reach(distance)) break;
    const Vec3& sample = samples_[candidate.index];
    // Samples around a point that was found lead there again.
    if (std::any_of(found.begin(), found.end(), [&](const Vec3& q) { return (q - sample).norm() < 2 * cover; }))
      continue;
    const Vec3 q = refine(p, sample);
    found.push_back(q);
    if ((q - p).norm() < distance) best = q, distance = (q - p).norm();
  }
  return {best, evaluate(best).gradient.normalized(), value(p) < 0 ? -distance : distance};
}

/// Dual to the cells of a grid (surface nets, Gibson 1998): a vertex in each cell whose corners lie on both sides, a
/// quadrilateral across each edge whose ends do. Layer by layer, so that the grid need not be stored.
Mesh Gyroid::net(double cell) const {
  const auto n = static_cast<std::size_t>(std::ceil(2 * ball_radius_ / cell)) + 2;
  const auto grid = [&](std::size_t x, std::size_t y, std::size_t z) {
    const double middle = static_cast<double>(n) / 2;
    return Vec3(cell * (Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)).array() - middle));
  };
  const auto at = [n](std::size_t x, std::size_t y) { return y * (n + 1) + x; };
  std::vector<double> below((n + 1) * (n + 1)), above = below;
  std::vector<Index> previous((n + 1) * (n + 1), no_index), here = previous;
  const auto fill = [&](std::vector<double>& layer, std::size_t z) {
    for (std::size_t y = 0; y <= n; ++y)
      for (std::size_t x = 0; x <= n; ++x) layer[at(x, y)] = value(grid(x, y, z));
  };
  Mesh mesh;
  const auto add = [&mesh](bool outward, Index a, Index b, Index c, Index d) {
    if (!outward) std::swap(b, d);
    const auto length = [&mesh](Index i, Index j) { return (mesh.positions[i] - mesh.positions[j]).squaredNorm(); };
    if (length(a, c) <= length(b, d))
      add_quad(mesh, a, b, c, d);
    else
      add_quad(mesh, b, c, d, a);
  };
  fill(below, 0);
  for (std::size_t z = 0; z < n; ++z) {
    fill(above, z + 1);
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t x = 0; x < n; ++x) {
        Vec3 sum = Vec3::Zero();
        int crossings = 0;
        const auto cross = [&](int i, int j) {  // corners as bits z, y, x
          const auto value_at = [&](int k) {
            return ((k & 4) != 0 ? above : below)[at(x + (k & 1), y + (k >> 1 & 1))];
          };
          const double from = value_at(i), to = value_at(j);
          if ((from < 0) == (to < 0)) return;
          const auto node = [&](int k) { return grid(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)); };
          sum += node(i) + from / (from - to) * (node(j) - node(i));
          ++crossings;
        };
        for (int corner = 0; corner < 8; ++corner)
          for (int bit = 1; bit < 8; bit *= 2)
            if ((corner & bit) == 0) cross(corner, corner | bit);
        here[at(x, y)] = crossings == 0 ? no_index : static_cast<Index>(mesh.positions.size());
        if (crossings > 0) mesh.positions.push_back(on_surface(sum / crossings));
      }
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t x = 0; x < n; ++x) {
        const bool inside = below[at(x, y)] < 0;
        if ((below[at(x + 1, y)] < 0) != inside)
          add(inside, previous[at(x, y - 1)], previous[at(x, y)], here[at(x, y)], here[at(x, y - 1)]);
        if ((below[at(x, y + 1)] < 0) != inside)
          add(inside, previous[at(x - 1, y)], here[at(x - 1, y)], here[at(x, y)], previous[at(x, y)]);
        if ((above[at(x, y)] < 0) != inside)
          add(inside, here[at(x - 1, y - 1)], here[at(x, y - 1)], here[at(x, y)], here[at(x - 1, y)]);
      }
    below.swap(above);
    previous.swap(here);
  }
  return mesh;
}

/// The triangles of a net have edges of up to 1.7 cells.
Mesh Gyroid::mesh(double tolerance) const {
  return net(std::min(sample_cell, std::sqrt(8 * tolerance / curvature_) / 1.7));
}

}  // namespace gpsrecon::internal
