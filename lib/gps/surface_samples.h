#pragma once

#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate_data.h>
#include <gpsrecon/gps/face_normals.h>
#include <gpsrecon/gps/limit_surface.h>
#include <Eigen/Geometry>
#include <cmath>

// Internal to lib/gps: positions, normals and deviations of a Gaussian-product surface at the vertices of a level.

namespace gpsrecon::internal {

/// Which samples are wanted.
struct SampleOptions {
  bool limit = true;  ///< positions and deviations of limits, else of the vertices; normals are of limits always
  bool spread = false;
  bool covariances = false;
};

namespace detail {

/// Below this sine of the angle between the two tangents they are taken for parallel.
inline constexpr double parallel_tangents = 1e-9;

/// A normal of any length and Σ times it; both zero where the tangents do not span a plane.
struct NormalAndSpread {
  Vec3 normal, spread;
};

/// With tangents Σa and Σb the normal is Σa × Σb = det Σ · Σ⁻¹(a × b), which takes no solution with Σ and loses the
/// fewer digits the flatter the Gaussian is.
inline NormalAndSpread limit_normal(const DualMap& map, const Sym3& precision, const DualPoint& q_u,
                                    const DualPoint& q_v) {
  const Vec3 a = map.cotangent(q_u), b = map.cotangent(q_v), m = a.cross(b), n = precision * m;
  // The sine is |Σa × Σb| / (|Σa| |Σb|) >= det Σ |n| / (tr Σ² |a| |b|), and tr Σ = c / det Σ⁻¹: nearly always that is
  // enough to tell.
  const Sym3& p = precision;
  const double xx = p.yy * p.zz - p.yz * p.yz, yy = p.xx * p.zz - p.xz * p.xz, zz = p.xx * p.yy - p.xy * p.xy;
  const double c = xx + yy + zz;
  const double determinant = p.xx * xx - p.xy * (p.xy * p.zz - p.yz * p.xz) + p.xz * (p.xy * p.yz - p.yy * p.xz);
  constexpr double clearly = 1e3 * parallel_tangents;
  const double lower = determinant * determinant * n.squaredNorm(),
               upper = c * c * c * c * a.squaredNorm() * b.squaredNorm();
  if (lower > clearly * clearly * upper) return {n, m};
  const Vec3 u = map.covariance_times(a), v = map.covariance_times(b);
  if (u.cross(v).norm() > parallel_tangents * u.norm() * v.norm()) return {n, m};
  return {Vec3::Zero(), Vec3::Zero()};
}

}  // namespace detail

/// Samples from the images `dual` at the vertices and the rows of their limits. Where the tangents do not span a plane
/// the normal is that of the faces around, or, failing that, the thin axis of the Gaussian (of either sign).
/// O(entries).
template <class LimitRows>
SurfaceSamples surface_samples(const LimitRows& limit, const std::vector<DualPoint>& dual,
                               const Normalization& normal_form, double sigma0, const FaceList& faces,
                               const SampleOptions& options, const RunContext& context) {
  const std::size_t count = limit.rows();
  SurfaceSamples samples;
  samples.positions.resize(count);
  samples.normals.resize(count);
  samples.sigma.resize(count);
  if (options.spread) samples.spread.resize(count);
  if (options.covariances) samples.covariances.resize(count);
  const auto set_normal = [&](std::size_t i, const Vec3& normal, const Vec3& spread) {
    samples.normals[i] = normal;
    if (options.spread) samples.spread[i] = normal_form.scale * spread;
    samples.sigma[i] = std::sqrt(std::max(0.0, normal_form.scale * normal.dot(spread) - sigma0 * sigma0));
  };
  parallel_blocks(count, context, [&](std::size_t, std::size_t begin, std::size_t end) {
    for_each_row<DualPoint>(limit, begin, end, dual, [&](std::size_t i, const Row<LimitWeight>& row) {
      const DualPoint q = apply_row<DualPoint>(row, dual, &LimitWeight::position);
      const DualMap limit_map(q);
      const auto [normal, spread] =
          detail::limit_normal(limit_map, quadratic_part(q), apply_row<DualPoint>(row, dual, &LimitWeight::u),
                               apply_row<DualPoint>(row, dual, &LimitWeight::v));
      const double length = normal.norm();
      if (!(length > 0)) {
        samples.normals[i].setZero();
      } else if (options.limit) {
        set_normal(i, normal / length, spread / length);
      }
      const DualMap map = options.limit ? limit_map : DualMap(dual[i]);
      samples.positions[i] = map.mean() + normal_form.center;
      if (options.covariances) samples.covariances[i] = normal_form.scale * map.covariance();
      if (!options.limit && length > 0) set_normal(i, normal / length, map.covariance_times(normal / length));
    });
  });
  std::vector<Index> room(longest_row(limit));
  for (const Index i : complete_normals(faces, samples.positions, samples.normals, context)) {
    const DualMap map(
        options.limit ? apply_row<DualPoint>(read_row(limit, i, room.data()), dual, &LimitWeight::position) : dual[i]);
    if (samples.normals[i].isZero(0)) samples.normals[i] = eigen_decomposition(map.covariance()).vectors.col(0);
    set_normal(i, samples.normals[i], map.covariance_times(samples.normals[i]));
  }
  return samples;
}

}  // namespace gpsrecon::internal
