// Order along a Morton curve: Morton 1966, "A computer oriented geodetic data base".

#include <gpsrecon/core/clean.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <bit>

namespace gpsrecon::internal {
namespace {

std::vector<Index> finite_points(const PointCloud& cloud) {
  std::vector<Index> finite;
  finite.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.positions[i].allFinite()) finite.push_back(static_cast<Index>(i));
  return finite;
}

/// Per axis the 1 % and 99 % quantiles, so that a few far points do not set the scale; the full box if these coincide
/// on all axes.
Box3 robust_box(const std::vector<Vec3>& points, const std::vector<Index>& finite) {
  Box3 box;
  std::vector<double> values(finite.size());
  const std::size_t low = finite.size() / 100, high = finite.size() - 1 - low;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < finite.size(); ++i) values[i] = points[finite[i]][axis];
    box.min()[axis] = value_of_rank(values, low);
    box.max()[axis] = value_of_rank(values, high);
  }
  return box.min() != box.max() ? box : bounding_box(points, finite);
}

Frame choose_frame(const Box3& box) {
  Frame frame;
  const double diagonal = box.diagonal().norm();
  if (diagonal > 0 && std::isfinite(diagonal)) std::frexp(diagonal, &frame.exponent), --frame.exponent;
  // A coarse grid for the origin keeps the change of frame free of rounding for all but far-away coordinates, so that
  // files in world coordinates give back the local bits.
  const double grid = std::ldexp(1.0, frame.exponent - 8);
  const Vec3 center = 0.5 * box.min() + 0.5 * box.max();
  for (int axis = 0; axis < 3; ++axis) frame.origin[axis] = std::nearbyint(center[axis] / grid) * grid;
  return frame;
}

/// Spreads the low 21 bits of v to every third bit.
std::uint64_t spread_bits(std::uint64_t v) {
  v = (v | v << 32) & 0x001F00000000FFFFull;
  v = (v | v << 16) & 0x001F0000FF0000FFull;
  v = (v | v << 8) & 0x100F00F00F00F00Full;
  v = (v | v << 4) & 0x10C30C30C30C30C3ull;
  return (v | v << 2) & 0x1249249249249249ull;
}

/// Morton code in the robust box. Ratios of lengths only, so that the code does not depend on units.
std::uint64_t morton_code(const Vec3& point, const Box3& box, double extent) {
  constexpr double cells = 1 << 21;
  std::uint64_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double share = extent > 0 ? (point[axis] - box.min()[axis]) / extent : 0;
    const auto cell = static_cast<std::uint64_t>(std::clamp(share * cells, 0.0, cells - 1));
    code |= spread_bits(cell) << axis;
  }
  return code;
}

}  // namespace

CleanCloud clean(const PointCloud& world, const RunContext& context) {
  CleanCloud result;
  const std::vector<Vec3>& points = world.positions;
  const std::vector<Index> finite = finite_points(world);
  result.non_finite = world.size() - finite.size();
  if (finite.empty()) throw InputError("the cloud holds no finite point (" + std::to_string(world.size()) + " rows)");

  const Box3 box = robust_box(points, finite);
  const Frame frame = choose_frame(box);
  const double extent = box.diagonal().maxCoeff();

  struct Key {
    std::uint64_t code;
    Index point;
  };
  std::vector<Key> keys(finite.size());
  parallel_for(finite.size(), context, [&](std::size_t i) {
    keys[i] = {morton_code(points[finite[i]], box, extent), finite[i]};
  });
  const auto lexicographic = [&](Index a, Index b) {
    const Vec3 &p = points[a], &q = points[b];
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    if (p.z() != q.z()) return p.z() < q.z();
    return a < b;
  };
  std::sort(keys.begin(), keys.end(), [&](const Key& a, const Key& b) {
    return a.code != b.code ? a.code < b.code : lexicographic(a.point, b.point);
  });

  // Equal points are neighbours in this order.
  result.source.reserve(keys.size());
  std::vector<double> weights;
  weights.reserve(keys.size());
  for (const Key& key : keys) {
    if (!result.source.empty() && points[result.source.back()] == points[key.point]) {
      weights.back() += world.weight(key.point);
      ++result.duplicates;
    } else {
      result.source.push_back(key.point);
      weights.push_back(world.weight(key.point));
    }
  }
  result.cloud = in_frame(select(world, result.source), frame);
  if (result.duplicates > 0 || !world.weights.empty()) result.cloud.weights = std::move(weights);
  return result;
}

}  // namespace gpsrecon::internal
