#pragma once

#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate_data.h>
#include <gpsrecon/gps/face_normals.h>
#include <gpsrecon/gps/limit_surface.h>
#include <Eigen/Geometry>
#include <cmath>

// Internal to lib/gps: positions, normals and deviations of a Gaussian-product surface at the vertices of a level.

namespace gpsrecon {

/// Which samples are wanted.
struct SampleOptions {
  bool limit = true;  ///< positions and deviations of limits, else of the vertices; normals are of limits always
  bool spread = false;
  bool covariances = false;
};

namespace detail {

struct LimitPoint {
  DualPoint position = DualPoint::Zero(), u = DualPoint::Zero(), v = DualPoint::Zero();
};

inline LimitPoint limit_point(const Row<LimitWeight>& row, const std::vector<DualPoint>& dual) {
  LimitPoint p;
  for (std::size_t j = 0; j < row.indices.size(); ++j) {
    const DualPoint& q = dual[row.indices[j]];
    p.position += row.weights[j].position * q;
    p.u += row.weights[j].u * q;
    p.v += row.weights[j].v * q;
  }
  return p;
}

/// Below this sine of the angle between the two tangents they are taken for parallel.
inline constexpr double parallel_tangents = 1e-9;

/// Zero where the tangents do not span a plane.
inline Vec3 unit_normal(const Vec3& u, const Vec3& v) {
  const Vec3 n = u.cross(v);
  const double length = n.norm();
  return length > parallel_tangents * u.norm() * v.norm() ? Vec3(n / length) : Vec3::Zero();
}

}  // namespace detail

/// Samples from the images `dual` at the vertices and the rows of their limits. Where the tangents do not span a plane
/// the normal is that of the faces around, or, failing that, the thin axis of the Gaussian (of either sign).
/// O(entries).
template <class LimitRows>
SurfaceSamples sample_surface(const LimitRows& limit, const std::vector<DualPoint>& dual,
                              const Normalization& normal_form, double sigma0, const FaceList& faces,
                              const SampleOptions& options, const RunContext& context) {
  const std::size_t count = limit.rows();
  SurfaceSamples samples;
  samples.positions.resize(count);
  samples.normals.resize(count);
  samples.sigma.resize(count);
  if (options.spread) samples.spread.resize(count);
  if (options.covariances) samples.covariances.resize(count);
  const auto describe = [&](std::size_t i, const DualMap& map) {
    const Vec3& n = samples.normals[i];
    const Vec3 spread = normal_form.scale * map.covariance_times(n);
    if (options.spread) samples.spread[i] = spread;
    samples.sigma[i] = std::sqrt(std::max(0.0, n.dot(spread) - sigma0 * sigma0));
  };
  parallel_blocks(count, context, [&](std::size_t, std::size_t begin, std::size_t end) {
    RowReader<LimitRows> rows(limit);
    for (std::size_t i = begin; i < end; ++i) {
      const detail::LimitPoint q = detail::limit_point(rows.read(i), dual);
      const DualMap limit_map(q.position);
      const DualMap map = options.limit ? limit_map : DualMap(dual[i]);
      samples.positions[i] = map.mean() + normal_form.center;
      if (options.covariances) samples.covariances[i] = normal_form.scale * map.covariance();
      samples.normals[i] = detail::unit_normal(limit_map.tangent(q.u), limit_map.tangent(q.v));
      describe(i, map);
    }
  });
  RowReader<LimitRows> rows(limit);
  for (const Index i : complete_normals(faces, samples.positions, samples.normals)) {
    const DualMap map(options.limit ? detail::limit_point(rows.read(i), dual).position : dual[i]);
    if (samples.normals[i].isZero(0)) samples.normals[i] = eigen_decomposition(map.covariance()).vectors.col(0);
    describe(i, map);
  }
  return samples;
}

}  // namespace gpsrecon
