#include <gpsrecon/core/point_cloud.h>

#include <gpsrecon/core/error.h>

namespace gpsrecon {
namespace {

void check_length(std::size_t length, std::size_t expected, const std::string& attribute) {
  if (length != 0 && length != expected)
    throw InvariantError("point cloud: " + attribute + " has " + std::to_string(length) + " entries for " +
                         std::to_string(expected) + " points");
}

template <class T>
std::vector<T> gather(const std::vector<T>& from, const std::vector<Index>& keep) {
  std::vector<T> to;
  if (from.empty()) return to;
  to.reserve(keep.size());
  for (const Index i : keep) to.push_back(from[i]);
  return to;
}

}  // namespace

void validate(const PointCloud& cloud) {
  const std::size_t n = cloud.size();
  check_length(cloud.normals.size(), n, "normals");
  check_length(cloud.colors.size(), n, "colors");
  check_length(cloud.weights.size(), n, "weights");
  check_length(cloud.sensors.size(), n, "sensors");
  for (const ScalarColumn& column : cloud.scalars)
    check_length(column.values.size(), n, "scalar '" + column.name + "'");
  for (std::size_t i = 0; i < n; ++i) {
    if (!cloud.positions[i].allFinite())
      throw InvariantError("point cloud: position " + std::to_string(i) + " is not finite");
    if (!(cloud.weight(i) > 0)) throw InvariantError("point cloud: weight " + std::to_string(i) + " is not positive");
  }
}

double bounding_box_diagonal(const std::vector<Vec3>& positions) {
  if (positions.empty()) return 0;
  Vec3 low = positions.front(), high = positions.front();
  for (const Vec3& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

PointCloud select(const PointCloud& cloud, const std::vector<Index>& keep) {
  PointCloud kept;
  kept.frame = cloud.frame;
  kept.positions = gather(cloud.positions, keep);
  kept.normals = gather(cloud.normals, keep);
  kept.colors = gather(cloud.colors, keep);
  kept.weights = gather(cloud.weights, keep);
  kept.sensors = gather(cloud.sensors, keep);
  for (const ScalarColumn& column : cloud.scalars) kept.scalars.push_back({column.name, gather(column.values, keep)});
  return kept;
}

}  // namespace gpsrecon
