#pragma once

#include <gpsrecon/core/point_cloud.h>
#include <array>
#include <optional>
#include <string>
#include <vector>

// Internal to lib/io: what the named columns of points or vertices mean, the same in every format.

namespace gpsrecon::internal::io {

/// Indices of the columns that mean something; all others are scalars. Names are compared without regard to case.
struct ColumnRoles {
  using Triple = std::array<std::size_t, 3>;
  std::optional<Triple> position;  ///< x y z
  std::optional<Triple> normal;    ///< nx ny nz, normal_x normal_y normal_z
  std::optional<Triple> color;     ///< red green blue, r g b, diffuse_red diffuse_green diffuse_blue
  std::optional<Triple> sensor;    ///< sx sy sz
  std::vector<std::size_t> others;
};
ColumnRoles column_roles(const std::vector<std::string>& names);

/// Makes those columns labels whose name says so, as long as their numbers are whole: class, classification, label,
/// segment, cluster, category, instance, object, material, region, part; in the plural too, after "scalar_" and before
/// "id" or "_id", without regard to case.
void recognize_labels(std::vector<ScalarColumn>& columns);

/// Numbers of one type by columns, as text files and PCD hold them.
struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;

  std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
};

/// Precondition: roles.position is set.
PointCloud cloud_of_table(Table table, const ColumnRoles& roles);

/// The columns as vectors.
std::vector<Vec3> to_vectors(const std::array<std::vector<double>, 3>& columns);

/// Colours from numbers that are not bytes: the range is 0..1 if no number is larger, else 0..255; what lies outside is
/// clamped and NaN is black.
std::vector<Color> to_colors(const std::array<std::vector<double>, 3>& columns);

}  // namespace gpsrecon::internal::io
