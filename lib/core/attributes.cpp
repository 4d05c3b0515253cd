#include <gpsrecon/core/attributes.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gpsrecon::internal {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t nearest_points = 8;
constexpr double reach_over_farthest = 1.1;  // where the weights vanish, in distances of the farthest of the points

double mean_value(const std::vector<double>& values, std::span<const WeightedPoint> points) {
  double sum = 0, weights = 0;
  for (const auto& [point, weight] : points) {
    if (is_missing(values[point])) continue;
    sum += weight * values[point];
    weights += weight;
  }
  return weights > 0 ? sum / weights : missing;
}

/// All vertices, neighbours close to each other: searches go faster from one to the next.
std::vector<Index> in_order_of_faces(const Mesh& mesh) {
  const std::size_t n = mesh.positions.size();
  std::vector<Index> order;
  order.reserve(n);
  std::vector<char> listed(n, 0);
  const auto list = [&](Index v) {
    if (!listed[v]) order.push_back(v);
    listed[v] = 1;
  };
  for (const Index v : mesh.faces.corners) list(v);
  for (Index v = 0; v < n; ++v) list(v);
  return order;
}

double majority(const std::vector<double>& values, std::span<const WeightedPoint> points) {
  const auto same = [&](const WeightedPoint& p) { return values[p.point] == values[points.front().point]; };
  if (!is_missing(values[points.front().point]) && std::all_of(points.begin(), points.end(), same))
    return values[points.front().point];
  std::vector<WeightedPoint> ordered;
  for (const WeightedPoint& p : points)
    if (!is_missing(values[p.point])) ordered.push_back(p);
  std::sort(ordered.begin(), ordered.end(), [&values](const WeightedPoint& a, const WeightedPoint& b) {
    return values[a.point] != values[b.point] ? values[a.point] < values[b.point] : a.point < b.point;
  });
  double winner = missing, most = 0;
  for (std::size_t begin = 0, end = 0; begin < ordered.size(); begin = end) {
    const double label = values[ordered[begin].point];
    double weight = 0;
    for (; end < ordered.size() && values[ordered[end].point] == label; ++end) weight += ordered[end].weight;
    if (weight <= most) continue;
    most = weight;
    winner = label;
  }
  return winner;
}

}  // namespace

Color mean_color(const std::vector<Color>& colors, std::span<const WeightedPoint> points) {
  Vec3 sum = Vec3::Zero();
  double weights = 0;
  for (const auto& [point, weight] : points) {
    const Color& c = colors[point];
    sum += weight * Vec3(c[0], c[1], c[2]);
    weights += weight;
  }
  const Vec3 mean = sum / weights;
  const auto byte = [](double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); };
  return {byte(mean[0]), byte(mean[1]), byte(mean[2])};
}

double combine(const ScalarColumn& column, std::span<const WeightedPoint> points) {
  return column.kind == ScalarKind::label ? majority(column.values, points) : mean_value(column.values, points);
}

void attributes_from_points(Mesh& mesh, const PointCloud& cloud, const RunContext& context) {
  if (!has_attributes(cloud) || cloud.empty()) return;
  const std::size_t n = mesh.positions.size();
  const Neighbors index(cloud.positions);
  mesh.colors.resize(cloud.colors.empty() ? 0 : n);
  mesh.scalars.clear();
  for (const ScalarColumn& column : cloud.scalars)
    mesh.scalars.push_back({column.name, std::vector<double>(n), column.kind});
  const std::vector<Index> order = in_order_of_faces(mesh);
  parallel_blocks(n, context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> near;
    std::vector<WeightedPoint> around;
    for (std::size_t k = begin; k < end; ++k) {
      const Index v = order[k];
      index.nearest(mesh.positions[v], nearest_points, near);
      const double reach = reach_over_farthest * near.back().distance;
      around.clear();
      for (const Neighbor& neighbor : near) {
        const double u = reach > 0 ? neighbor.distance / reach : 0;
        around.push_back({neighbor.index, cloud.weight(neighbor.index) * (1 - u * u) * (1 - u * u)});
      }
      if (!cloud.colors.empty()) mesh.colors[v] = mean_color(cloud.colors, around);
      for (std::size_t c = 0; c < cloud.scalars.size(); ++c)
        mesh.scalars[c].values[v] = combine(cloud.scalars[c], around);
    }
  });
}

}  // namespace gpsrecon::internal
