#include <gpsrecon/core/point_cloud.h>

#include <gpsrecon/core/error.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

namespace gpsrecon {
namespace {

void check_length(std::size_t length, std::size_t expected, const std::string& attribute) {
  if (length != 0 && length != expected)
    throw InvariantError("point cloud: " + attribute + " has " + std::to_string(length) + " entries for " +
                         std::to_string(expected) + " points");
}

bool same_letters(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
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

bool is_missing(double value) {
  return !(std::abs(value) < static_cast<double>(std::numeric_limits<float>::max()));
}

bool is_whole(const ScalarColumn& column) {
  return std::all_of(column.values.begin(), column.values.end(),
                     [](double value) { return is_missing(value) || std::trunc(value) == value; });
}

void mark_labels(std::vector<ScalarColumn>& columns, const std::vector<std::string>& labels) {
  for (const std::string& label : labels) {
    const auto column = std::find_if(columns.begin(), columns.end(),
                                     [&](const ScalarColumn& c) { return same_letters(c.name, label); });
    if (column == columns.end()) throw OptionError("labels: there is no column '" + label + "'");
    if (!is_whole(*column)) throw OptionError("labels: column '" + label + "' holds numbers that are not whole");
    column->kind = ScalarKind::label;
  }
}

void mark_missing(std::vector<ScalarColumn>& columns, double no_data) {
  for (ScalarColumn& column : columns)
    for (double& value : column.values)
      if (static_cast<float>(value) == static_cast<float>(no_data)) value = std::numeric_limits<double>::quiet_NaN();
}

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

PointCloud select(const PointCloud& cloud, const std::vector<Index>& keep) {
  PointCloud kept;
  kept.frame = cloud.frame;
  kept.positions = gather(cloud.positions, keep);
  kept.normals = gather(cloud.normals, keep);
  kept.colors = gather(cloud.colors, keep);
  kept.weights = gather(cloud.weights, keep);
  kept.sensors = gather(cloud.sensors, keep);
  for (const ScalarColumn& column : cloud.scalars)
    kept.scalars.push_back({column.name, gather(column.values, keep), column.kind});
  return kept;
}

}  // namespace gpsrecon
