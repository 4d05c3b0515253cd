#include <gpsrecon/measure/held_out_error.h>

#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/measure/distance.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace gpsrecon::internal {
namespace {

/// In median offsets: 4.7 standard deviations of normal noise.
constexpr double outlier_distance = 7;
/// Feet looked at for one that is on the same side, and to tell outliers from a part of the surface that is wrong.
constexpr std::size_t candidates = 6;

/// A point seen from the surface.
struct Foot {
  Vec3 point, normal;
  double offset = 0;  ///< of the point from its foot, positive on the side of the normal
};

std::vector<Foot> feet_of(const Mesh& mesh, std::span<const Vec3> points, const RunContext& context) {
  const std::vector<ClosestPoint> closest = SurfaceDistance(mesh, context).distances(points, context);
  std::vector<Foot> feet(points.size());
  parallel_for(points.size(), context, [&](std::size_t i) {
    const ClosestPoint& c = closest[i];
    const Vec3 normal = unit_normal(mesh.positions, mesh.faces[c.face]);
    const double along = normal.dot(points[i] - c.point);
    // Farther sideways than along the normal: the foot is on a rim, and the side means nothing.
    const double offset = std::abs(along) < 0.5 * c.distance ? c.distance : std::copysign(c.distance, along);
    feet[i] = {c.point, normal, offset};
  });
  return feet;
}

/// Per foot the nearest other one on the same side of the surface, no_index if there is none near, or if the point is
/// an outlier: farther out than `bound` while half of those around it are not.
std::vector<Index> partners_of(const std::vector<Foot>& feet, double bound, const RunContext& context) {
  std::vector<Vec3> positions;
  positions.reserve(feet.size());
  for (const Foot& f : feet) positions.push_back(f.point);
  const Neighbors index(positions);
  std::vector<Index> partner(feet.size(), no_index);
  parallel_blocks(feet.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> near;
    for (std::size_t i = begin; i < end; ++i) {
      index.nearest(feet[i].point, candidates, near);
      const auto beyond = static_cast<std::size_t>(std::count_if(
          near.begin(), near.end(), [&](const Neighbor& n) { return std::abs(feet[n.index].offset) > bound; }));
      if (std::abs(feet[i].offset) > bound && 2 * beyond <= near.size()) continue;
      for (const Neighbor& n : near) {
        if (n.index == i || feet[n.index].normal.dot(feet[i].normal) <= 0.5) continue;
        partner[i] = n.index;
        break;
      }
    }
  });
  return partner;
}

double median_offset(const std::vector<Foot>& feet) {
  std::vector<double> offsets;
  offsets.reserve(feet.size());
  for (const Foot& f : feet) offsets.push_back(std::abs(f.offset));
  return median(offsets);
}

}  // namespace

double HeldOutError::bound() const {
  return std::sqrt(std::max(0.0, mean_square) + standard_error);
}

HeldOutError held_out_error(const Mesh& mesh, std::span<const Vec3> points, const RunContext& context) {
  HeldOutError error;
  if (points.empty()) return error;
  const std::vector<Foot> feet = feet_of(mesh, points, context);
  const std::vector<Index> partner = partners_of(feet, outlier_distance * median_offset(feet), context);
  double sum = 0, squares = 0;
  for (Index i = 0; i < feet.size(); ++i) {
    const Index j = partner[i];
    if (j == no_index || partner[j] == no_index) continue;
    if (partner[j] == i && j < i) continue;  // two that have each other are one pair
    const double a = feet[i].offset, b = feet[j].offset;
    sum += a * b;
    squares += a * b * a * b;
    ++error.pairs;
  }
  if (error.pairs == 0) return error;
  const auto n = static_cast<double>(error.pairs);
  error.mean_square = sum / n;
  error.standard_error = std::sqrt(std::max(0.0, squares / n - error.mean_square * error.mean_square) / n);
  return error;
}

}  // namespace gpsrecon::internal
