#include "columns.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "text.h"

namespace gpsrecon::internal::io {
namespace {

using NameTriple = std::array<std::string_view, 3>;

std::optional<ColumnRoles::Triple> find_triple(const std::vector<std::string>& names, const NameTriple& wanted) {
  ColumnRoles::Triple found;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto name = std::find_if(names.begin(), names.end(),
                                   [&](const std::string& candidate) { return same_word(candidate, wanted[axis]); });
    if (name == names.end()) return {};
    found[axis] = static_cast<std::size_t>(name - names.begin());
  }
  return found;
}

std::optional<ColumnRoles::Triple> find_first(const std::vector<std::string>& names,
                                              std::initializer_list<NameTriple> alternatives) {
  for (const NameTriple& wanted : alternatives)
    if (const auto found = find_triple(names, wanted)) return found;
  return {};
}

bool names_label(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  if (name.starts_with("scalar_")) name.erase(0, 7);
  for (const std::string_view ending : {"id", "_", "s"})
    if (name.ends_with(ending) && name != "class") name.erase(name.size() - ending.size());
  constexpr std::string_view known[] = {"class",    "classification", "label",    "segment", "cluster", "category",
                                        "instance", "object",         "material", "region",  "part"};
  return std::find(std::begin(known), std::end(known), name) != std::end(known);
}

}  // namespace

ColumnRoles column_roles(const std::vector<std::string>& names) {
  ColumnRoles roles;
  roles.position = find_triple(names, {"x", "y", "z"});
  roles.normal = find_first(names, {{"nx", "ny", "nz"}, {"normal_x", "normal_y", "normal_z"}});
  roles.color =
      find_first(names, {{"red", "green", "blue"}, {"r", "g", "b"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}});
  roles.sensor = find_triple(names, {"sx", "sy", "sz"});
  std::vector<bool> used(names.size(), false);
  for (const auto* triple : {&roles.position, &roles.normal, &roles.color, &roles.sensor})
    if (*triple)
      for (const std::size_t column : **triple) used[column] = true;
  for (std::size_t column = 0; column < names.size(); ++column)
    if (!used[column]) roles.others.push_back(column);
  return roles;
}

void recognize_labels(std::vector<ScalarColumn>& columns) {
  for (ScalarColumn& column : columns)
    if (names_label(column.name) && is_whole(column)) column.kind = ScalarKind::label;
}

PointCloud cloud_of_table(Table table, const ColumnRoles& roles) {
  const auto take = [&table](const ColumnRoles::Triple& triple) {
    return std::array{std::move(table.columns[triple[0]]), std::move(table.columns[triple[1]]),
                      std::move(table.columns[triple[2]])};
  };
  PointCloud cloud;
  cloud.positions = to_vectors(take(*roles.position));
  if (roles.normal) cloud.normals = to_vectors(take(*roles.normal));
  if (roles.color) cloud.colors = to_colors(take(*roles.color));
  if (roles.sensor) cloud.sensors = to_vectors(take(*roles.sensor));
  for (const std::size_t column : roles.others)
    cloud.scalars.push_back({std::move(table.names[column]), std::move(table.columns[column])});
  recognize_labels(cloud.scalars);
  return cloud;
}

std::vector<Vec3> to_vectors(const std::array<std::vector<double>, 3>& columns) {
  std::vector<Vec3> vectors(columns[0].size());
  for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = {columns[0][i], columns[1][i], columns[2][i]};
  return vectors;
}

std::vector<Color> to_colors(const std::array<std::vector<double>, 3>& columns) {
  double largest = 0;
  for (const std::vector<double>& column : columns)
    for (const double value : column) largest = std::max(largest, value);  // false for NaN
  const double scale = largest <= 1 ? 255 : 1;
  std::vector<Color> colors(columns[0].size());
  for (std::size_t i = 0; i < colors.size(); ++i)
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double value = scale * columns[channel][i];
      colors[i][channel] = value > 0 ? static_cast<std::uint8_t>(std::lround(std::min(value, 255.0))) : std::uint8_t{0};
    }
  return colors;
}

}  // namespace gpsrecon::internal::io
