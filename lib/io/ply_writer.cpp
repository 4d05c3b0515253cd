// PLY files of points, mixtures, covariance meshes and meshes.

#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/mixture_rows.h>
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "columns.h"
#include "formats.h"
#include "output_file.h"
#include "ply_comment.h"
#include "precision.h"

namespace gpsrecon::internal::io {
namespace {

using NameTriple = std::array<const char*, 3>;

// One property of the vertices: row i is real[i * stride] or byte[i * stride].
struct Column {
  std::string name;
  PlyType type;
  std::size_t stride = 1;
  const double* real = nullptr;
  const std::uint8_t* byte = nullptr;
};

// Collects a row or two before they go to the file.
class Buffer {
 public:
  explicit Buffer(OutputFile& file) : file_(file) { text_.reserve(capacity + 4096); }

  template <class T>
  void add_binary(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if constexpr (std::endian::native == std::endian::big) std::reverse(bytes, bytes + sizeof(T));
    text_.append(bytes, sizeof(T));
  }
  // The shortest text that reads back as the same number.
  template <class T>
  void add_text(T value, char separator) {
    char digits[40];
    char* const end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
    *end = separator;
    text_.append(digits, end + 1);
  }
  void end_row() {
    if (text_.size() >= capacity) flush();
  }
  void flush() {
    file_.write(text_);
    text_.clear();
  }

 private:
  static constexpr std::size_t capacity = 1 << 16;
  OutputFile& file_;
  std::string text_;
};

std::string header_of(PlyEncoding encoding, const std::vector<std::string>& comments, std::size_t vertices,
                      const std::vector<Column>& columns, const FaceList* faces, PlyType length_type) {
  std::string header = "ply\nformat ";
  header += encoding == PlyEncoding::ascii ? "ascii" : "binary_little_endian";
  header += " 1.0\n";
  for (const std::string& comment : comments) header += "comment " + comment + "\n";
  header += "element vertex " + std::to_string(vertices) + "\n";
  for (const Column& column : columns)
    header += std::string("property ") + name_of(column.type) + " " + column.name + "\n";
  if (faces != nullptr)
    header += "element face " + std::to_string(faces->size()) + "\nproperty list " + name_of(length_type) +
              " int vertex_indices\n";
  return header + "end_header\n";
}

void write_vertices(Buffer& buffer, PlyEncoding encoding, std::size_t count, const std::vector<Column>& columns) {
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const Column& column = columns[c];
      const char separator = c + 1 < columns.size() ? ' ' : '\n';
      const auto add = [&](auto value) {
        if (encoding == PlyEncoding::ascii)
          buffer.add_text(value, separator);
        else
          buffer.add_binary(value);
      };
      if (column.byte != nullptr)
        add(column.byte[i * column.stride]);
      else if (column.type == PlyType::float32)
        add(static_cast<float>(column.real[i * column.stride]));
      else if (column.type == PlyType::int32)
        add(static_cast<std::int32_t>(column.real[i * column.stride]));
      else
        add(column.real[i * column.stride]);
    }
    buffer.end_row();
  }
}

void write_faces(Buffer& buffer, PlyEncoding encoding, const FaceList& faces, PlyType length_type) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::span<const Index> face = faces[f];
    if (encoding == PlyEncoding::ascii) {
      buffer.add_text(face.size(), face.empty() ? '\n' : ' ');
      for (std::size_t k = 0; k < face.size(); ++k) buffer.add_text(face[k], k + 1 < face.size() ? ' ' : '\n');
    } else {
      if (length_type == PlyType::uint8)
        buffer.add_binary(static_cast<std::uint8_t>(face.size()));
      else
        buffer.add_binary(static_cast<std::uint32_t>(face.size()));
      for (const Index corner : face) buffer.add_binary(corner);
    }
    buffer.end_row();
  }
}

PlyType length_type_of(const FaceList& faces) {
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (faces[f].size() > 255) return PlyType::uint32;
  return PlyType::uint8;
}

void write_file(const std::string& path, PlyEncoding encoding, const std::vector<std::string>& comments,
                std::size_t vertices, const std::vector<Column>& columns, const FaceList* faces) {
  const PlyType length_type = faces != nullptr ? length_type_of(*faces) : PlyType::uint8;
  OutputFile file(path);
  file.write(header_of(encoding, comments, vertices, columns, faces, length_type));
  Buffer buffer(file);
  write_vertices(buffer, encoding, vertices, columns);
  if (faces != nullptr) write_faces(buffer, encoding, *faces, length_type);
  buffer.flush();
  file.commit();
}

bool survives_float(double value) {
  return static_cast<float>(value) == value || std::isnan(value);
}

// float where that loses nothing
PlyType lossless_type(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), survives_float) ? PlyType::float32 : PlyType::float64;
}
PlyType lossless_type(const std::vector<Vec3>& values) {
  const auto survives = [](const Vec3& v) {
    return survives_float(v[0]) && survives_float(v[1]) && survives_float(v[2]);
  };
  return std::all_of(values.begin(), values.end(), survives) ? PlyType::float32 : PlyType::float64;
}

// int for labels that fit; else float where that moves no value by more than 1e-6 of their range
PlyType scalar_type(const ScalarColumn& scalar) {
  const auto is_int = [](double value) {
    return std::trunc(value) == value && std::abs(value) <= std::numeric_limits<std::int32_t>::max();
  };
  if (scalar.kind == ScalarKind::label && std::all_of(scalar.values.begin(), scalar.values.end(), is_int))
    return PlyType::int32;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : scalar.values)
    if (!is_missing(value)) low = std::min(low, value), high = std::max(high, value);
  const double tolerance = 1e-6 * (high - low);
  const bool fits = std::all_of(scalar.values.begin(), scalar.values.end(), [tolerance](double value) {
    return is_missing(value) || std::abs(static_cast<double>(static_cast<float>(value)) - value) <= tolerance;
  });
  return fits ? PlyType::float32 : PlyType::float64;
}

void add_vectors(std::vector<Column>& columns, const NameTriple& names, PlyType type, const std::vector<Vec3>& values) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    columns.push_back({.name = names[axis],
                       .type = type,
                       .stride = 3,
                       .real = values.empty() ? nullptr : values.front().data() + axis});
}

void add_colors(std::vector<Column>& columns, const std::vector<Color>& colors) {
  const NameTriple names{"red", "green", "blue"};
  for (std::size_t channel = 0; channel < 3 && !colors.empty(); ++channel)
    columns.push_back(
        {.name = names[channel], .type = PlyType::uint8, .stride = 3, .byte = colors.front().data() + channel});
}

// Adds a column under its name, or one like it that no other column has.
void add_scalar(std::vector<Column>& columns, const ScalarColumn& scalar, PlyType type) {
  std::vector<std::string> taken;
  taken.reserve(columns.size());
  for (const Column& column : columns) taken.push_back(column.name);
  columns.push_back({.name = property_name(scalar.name, taken), .type = type, .real = scalar.values.data()});
}

std::vector<Column> gaussian_columns(const MixtureRows& rows) {
  std::vector<Column> columns;
  for (const double* first = rows.values.data(); const std::size_t c : rows.layout.columns())
    columns.push_back({.name = mixture_columns[c], .type = PlyType::float64, .stride = rows.row_size, .real = first++});
  return columns;
}

/// `mesh` is null for a mixture without faces.
void write_gaussians(const Mixture& mixture, const CovMesh* mesh, const std::string& path, PlyEncoding encoding) {
  const MixtureRows rows = to_rows(mixture);
  const double world_sigma0 = std::ldexp(mixture.sigma0, mixture.frame.exponent);
  const double world_spacing = std::ldexp(mixture.spacing, mixture.frame.exponent);
  std::vector<Column> columns = gaussian_columns(rows);
  add_colors(columns, mixture.colors);
  std::vector<std::string> labels;
  for (const ScalarColumn& scalar : mixture.scalars) {
    add_scalar(columns, scalar, PlyType::float64);
    if (scalar.kind == ScalarKind::label) labels.push_back(columns.back().name);
  }
  std::vector<std::string> comments{frame_comment({mixture.frame, world_sigma0, world_spacing})};
  if (!labels.empty()) comments.push_back(label_comment(labels));
  if (mesh != nullptr) comments.push_back(rules_comment(mesh->rules));
  write_file(path, encoding, comments, mixture.size(), columns, mesh != nullptr ? &mesh->faces : nullptr);
}

}  // namespace

void write_ply(const PointCloud& cloud, const std::string& path, PlyEncoding encoding) {
  const std::vector<Vec3> positions = in_frame(cloud.positions, cloud.frame, Frame{});
  const std::vector<Vec3> sensors = in_frame(cloud.sensors, cloud.frame, Frame{});
  std::vector<Column> columns;
  add_vectors(columns, {"x", "y", "z"}, lossless_type(positions), positions);
  if (!cloud.normals.empty()) add_vectors(columns, {"nx", "ny", "nz"}, lossless_type(cloud.normals), cloud.normals);
  add_colors(columns, cloud.colors);
  if (!sensors.empty()) add_vectors(columns, {"sx", "sy", "sz"}, lossless_type(sensors), sensors);
  for (const ScalarColumn& scalar : cloud.scalars) add_scalar(columns, scalar, lossless_type(scalar.values));
  write_file(path, encoding, {version_comment()}, cloud.size(), columns, nullptr);
}

void write_ply(const Mixture& mixture, const std::string& path, PlyEncoding encoding) {
  write_gaussians(mixture, nullptr, path, encoding);
}

void write_ply(const CovMesh& mesh, const std::string& path, PlyEncoding encoding) {
  write_gaussians(mesh.vertices, &mesh, path, encoding);
}

void write_ply(const Mesh& mesh, const std::string& path, PlyEncoding encoding) {
  const std::vector<Vec3> positions = in_frame(mesh.positions, mesh.frame, Frame{});
  std::vector<double> sigma = mesh.sigma;
  for (double& s : sigma) s *= mesh.frame.scale();
  const PlyType type = float_suffices(positions) ? PlyType::float32 : PlyType::float64;
  std::vector<Column> columns;
  add_vectors(columns, {"x", "y", "z"}, type, positions);
  if (!mesh.normals.empty()) add_vectors(columns, {"nx", "ny", "nz"}, PlyType::float32, mesh.normals);
  add_colors(columns, mesh.colors);
  if (!sigma.empty()) columns.push_back({.name = "sigma", .type = type, .real = sigma.data()});
  // In double, as rounding to float may leave thin ones without an inverse.
  std::vector<double> covariances;
  constexpr std::size_t numbers = 6, first = 3;
  covariances.reserve(numbers * mesh.covariances.size());
  for (const Sym3& local : mesh.covariances) {
    const Sym3 c = local * (mesh.frame.scale() * mesh.frame.scale());
    covariances.insert(covariances.end(), {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz});
  }
  for (std::size_t k = 0; k < numbers && !covariances.empty(); ++k)
    columns.push_back({.name = mixture_columns[first + k],
                       .type = PlyType::float64,
                       .stride = numbers,
                       .real = covariances.data() + k});
  for (const ScalarColumn& scalar : mesh.scalars) add_scalar(columns, scalar, scalar_type(scalar));
  write_file(path, encoding, {version_comment()}, positions.size(), columns, &mesh.faces);
}

}  // namespace gpsrecon::internal::io
