// Reads PCD files through PCL.

#include "pcd_plugin.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

namespace {

struct Columns {
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;

  std::vector<double>& add(const std::string& name, std::size_t rows) {
    names.push_back(name);
    return values.emplace_back(rows);
  }
};

template <class T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

template <class T>
void load_column(const pcl::PCLPointCloud2& cloud, std::size_t offset, std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<double>(load<T>(cloud.data.data() + i * cloud.point_step + offset));
}

// Three bytes in one number, whatever type it pretends to have.
void add_colors(const pcl::PCLPointCloud2& cloud, const pcl::PCLPointField& field, std::size_t rows, Columns& columns) {
  const char* const names[] = {"red", "green", "blue"};
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<double>& values = columns.add(names[channel], rows);
    for (std::size_t i = 0; i < rows; ++i)
      values[i] =
          load<std::uint32_t>(cloud.data.data() + i * cloud.point_step + field.offset) >> (16 - 8 * channel) & 0xFF;
  }
}

void add_field(const pcl::PCLPointCloud2& cloud, const pcl::PCLPointField& field, std::size_t rows, Columns& columns) {
  using Field = pcl::PCLPointField;
  if (field.name == "_" || field.count != 1) return;  // padding, histograms
  const bool four_bytes =
      field.datatype == Field::FLOAT32 || field.datatype == Field::UINT32 || field.datatype == Field::INT32;
  if ((field.name == "rgb" || field.name == "rgba") && four_bytes) return add_colors(cloud, field, rows, columns);
  std::vector<double>& values = columns.add(field.name, rows);
  switch (field.datatype) {
    case Field::BOOL:
    case Field::UINT8:
      return load_column<std::uint8_t>(cloud, field.offset, values);
    case Field::INT8:
      return load_column<std::int8_t>(cloud, field.offset, values);
    case Field::INT16:
      return load_column<std::int16_t>(cloud, field.offset, values);
    case Field::UINT16:
      return load_column<std::uint16_t>(cloud, field.offset, values);
    case Field::INT32:
      return load_column<std::int32_t>(cloud, field.offset, values);
    case Field::UINT32:
      return load_column<std::uint32_t>(cloud, field.offset, values);
    case Field::INT64:
      return load_column<std::int64_t>(cloud, field.offset, values);
    case Field::UINT64:
      return load_column<std::uint64_t>(cloud, field.offset, values);
    case Field::FLOAT32:
      return load_column<float>(cloud, field.offset, values);
    case Field::FLOAT64:
      return load_column<double>(cloud, field.offset, values);
    default:
      throw std::runtime_error("field '" + field.name + "' has an unknown type");
  }
}

Columns read_columns(const char* path) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // errors are reported by their return value
  pcl::PCLPointCloud2 cloud;
  if (pcl::PCDReader().read(path, cloud) != 0) throw std::runtime_error("expected a PCD file that PCL can read");
  const std::size_t rows = std::size_t{cloud.width} * cloud.height;
  if (cloud.data.size() < rows * cloud.point_step) throw std::runtime_error("expected more data");
  Columns columns;
  for (const pcl::PCLPointField& field : cloud.fields) add_field(cloud, field, rows, columns);
  return columns;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) int gpsrecon_read_pcd(
    const char* path, void (*receive)(void* context, const GpsreconPcdTable* table), void* context, char* error,
    std::size_t error_size) {
  try {
    const Columns columns = read_columns(path);
    std::vector<const char*> names;
    std::vector<const double*> values;
    for (const std::string& name : columns.names) names.push_back(name.c_str());
    for (const std::vector<double>& column : columns.values) values.push_back(column.data());
    const std::uint64_t rows = columns.values.empty() ? 0 : columns.values.front().size();
    const GpsreconPcdTable table{rows, columns.values.size(), names.data(), values.data()};
    receive(context, &table);
    return 0;
  } catch (const std::exception& exception) {
    std::snprintf(error, error_size, "%s", exception.what());
  } catch (...) {
    std::snprintf(error, error_size, "unknown error");
  }
  return 1;
}
