// Points, mixtures, covariance meshes and meshes from the elements of a PLY file.

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mixture_rows.h>
#include <algorithm>
#include <cmath>

#include "columns.h"
#include "formats.h"
#include "ply_body.h"
#include "ply_comment.h"
#include "text.h"

namespace gpsrecon::internal::io {
namespace {

using ColumnTriple = std::array<std::vector<double>, 3>;

// The scalar properties of an element by name; lists get an empty name, so that no role falls on them.
std::vector<std::string> scalar_names(const PlyElement& element) {
  std::vector<std::string> names;
  for (const PlyProperty& p : element.properties) names.push_back(p.is_list ? std::string() : p.name);
  return names;
}

const PlyElement& vertices_of(const InputFile& file, const PlyHeader& header) {
  const PlyElement* const element = header.vertices();
  if (element == nullptr) file.fail("expected an element 'vertex' in the header, found none");
  return *element;
}

void add_vector_sinks(PlyRequest& request, const ColumnRoles::Triple& triple, std::vector<Vec3>& vectors) {
  vectors.resize(request.element->count);
  double* const numbers = vectors.empty() ? nullptr : vectors.front().data();
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  for (std::size_t axis = 0; axis < 3 && numbers != nullptr; ++axis)
    request.sinks.push_back({.property = triple[axis], .stride = 3, .real = numbers + axis});
}

bool is_mixture_column(const std::string& name) {
  return std::find(std::begin(mixture_columns), std::end(mixture_columns), name) != std::end(mixture_columns);
}

// What the properties mean; lists mean nothing.
ColumnRoles roles_of(const PlyElement& element) {
  ColumnRoles roles = column_roles(scalar_names(element));
  std::erase_if(roles.others, [&element](std::size_t p) { return element.properties[p].is_list; });
  return roles;
}

// Gaussians have, besides what makes them up, a colour and scalars, whatever the names of these.
ColumnRoles attribute_roles(const PlyElement& element) {
  ColumnRoles roles;
  roles.color = column_roles(scalar_names(element)).color;
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const PlyProperty& property = element.properties[p];
    const bool is_color = roles.color && std::find(roles.color->begin(), roles.color->end(), p) != roles.color->end();
    if (!property.is_list && !is_color && !is_mixture_column(property.name)) roles.others.push_back(p);
  }
  return roles;
}

// Reads the attributes that points, the vertices of meshes and Gaussians share. A PointCloud serves for all of them.
struct VertexReader {
  PlyRequest request;
  PointCloud cloud;
  ColumnTriple wide_colors;  // colours of any type but bytes, until their range is known

  VertexReader(const PlyElement& element, const ColumnRoles& roles) {
    request.element = &element;
    if (roles.position) add_vector_sinks(request, *roles.position, cloud.positions);
    if (roles.normal) add_vector_sinks(request, *roles.normal, cloud.normals);
    if (roles.sensor) add_vector_sinks(request, *roles.sensor, cloud.sensors);
    if (roles.color) add_color_sinks(*roles.color);
    cloud.scalars.reserve(roles.others.size());
    for (const std::size_t p : roles.others) {
      ScalarColumn& column = cloud.scalars.emplace_back();
      column.name = element.properties[p].name;
      column.values.resize(element.count);
      request.sinks.push_back({.property = p, .real = column.values.data()});
    }
  }

  void add_color_sinks(const ColumnRoles::Triple& triple) {
    const PlyElement& element = *request.element;
    const bool bytes = std::all_of(triple.begin(), triple.end(),
                                   [&element](std::size_t p) { return element.properties[p].type == PlyType::uint8; });
    if (bytes) cloud.colors.resize(element.count);
    for (std::size_t channel = 0; channel < 3 && element.count > 0; ++channel) {
      PlySink sink{.property = triple[channel]};
      if (bytes) {
        sink.stride = 3;
        sink.byte = cloud.colors.front().data() + channel;
      } else {
        wide_colors[channel].resize(element.count);
        sink.real = wide_colors[channel].data();
      }
      request.sinks.push_back(sink);
    }
  }

  PointCloud finish() {
    if (!wide_colors[0].empty()) cloud.colors = to_colors(wide_colors);
    recognize_labels(cloud.scalars);
    return std::move(cloud);
  }
};

VertexReader vertex_reader(const InputFile& file, const PlyHeader& header) {
  const PlyElement& element = vertices_of(file, header);
  const ColumnRoles roles = roles_of(element);
  if (!roles.position) file.fail("expected properties 'x', 'y', 'z' of element " + quote(element.name));
  return {element, roles};
}

std::string index_problem(std::span<const std::int64_t> corners, std::uint64_t vertex_count) {
  for (const std::int64_t corner : corners)
    if (corner < 0 || static_cast<std::uint64_t>(corner) >= vertex_count)
      return "expected vertex indices below " + std::to_string(vertex_count) + ", found " + std::to_string(corner);
  return {};
}

// Splits a triangle strip; -1 ends one strip and begins the next, and triangles without area join strips.
std::string add_strip(std::span<const std::int64_t> strip, std::uint64_t vertex_count, FaceList& faces) {
  for (std::size_t begin = 0; begin < strip.size();) {
    std::size_t end = begin;
    while (end < strip.size() && strip[end] != -1) ++end;
    const std::span<const std::int64_t> part = strip.subspan(begin, end - begin);
    if (std::string problem = index_problem(part, vertex_count); !problem.empty()) return problem;
    for (std::size_t i = 0; i + 2 < part.size(); ++i) {
      // Every second triangle of a strip runs the other way.
      const Index a = static_cast<Index>(part[i + i % 2]), b = static_cast<Index>(part[i + 1 - i % 2]),
                  c = static_cast<Index>(part[i + 2]);
      if (a != b && b != c && c != a) faces.add(a, b, c);
    }
    begin = end + 1;
  }
  return {};
}

std::string add_polygon(std::span<const std::int64_t> polygon, std::uint64_t vertex_count, FaceList& faces) {
  if (polygon.size() < 3) return "expected a face of at least 3 corners, found " + std::to_string(polygon.size());
  if (faces.corners.size() + polygon.size() > no_index) return "expected less than 2^32 corners of faces";
  if (std::string problem = index_problem(polygon, vertex_count); !problem.empty()) return problem;
  for (const std::int64_t corner : polygon) faces.corners.push_back(static_cast<Index>(corner));
  faces.offsets.push_back(static_cast<std::uint32_t>(faces.corners.size()));
  return {};
}

// The list of corners of an element; none if the element has no such list.
const PlyProperty* corner_list(const PlyElement& element) {
  for (const PlyProperty& p : element.properties)
    if (p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index")) return &p;
  return nullptr;
}

void add_face_requests(const PlyHeader& header, std::uint64_t vertex_count, FaceList& faces,
                       std::vector<PlyRequest>& requests) {
  for (const char* const name : {"face", "tristrips"}) {
    const PlyElement* const element = header.find(name);
    const PlyProperty* const list = element != nullptr ? corner_list(*element) : nullptr;
    if (list == nullptr) continue;
    const bool strips = element->name == "tristrips";
    PlyRequest request{.element = element};
    request.list = static_cast<std::size_t>(list - element->properties.data());
    request.on_list = [strips, vertex_count, &faces](std::span<const std::int64_t> entries) {
      return strips ? add_strip(entries, vertex_count, faces) : add_polygon(entries, vertex_count, faces);
    };
    if (!strips) faces.reserve(element->count, 3 * element->count);
    requests.push_back(std::move(request));
  }
}

bool has_covariances(const PlyElement* element) {
  if (element == nullptr) return false;
  const std::vector<std::string> names = scalar_names(*element);
  return std::all_of(mixture_columns, mixture_columns + 9,
                     [&names](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); });
}

// Reads the Gaussians, and the faces if `faces` is not null.
Mixture read_gaussians(const InputFile& file, const PlyHeader& header, FaceList* faces) {
  const PlyElement& element = vertices_of(file, header);
  if (!has_covariances(&element))
    file.fail("expected properties x y z covxx covxy covxz covyy covyz covzz of element " + quote(element.name));
  const std::vector<std::string> names = scalar_names(element);
  const auto property = [&names](const char* name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const auto has = [&](std::size_t first, std::size_t end) {
    return std::all_of(mixture_columns + first, mixture_columns + end,
                       [&](const char* name) { return property(name) < names.size(); });
  };
  MixtureRows rows({.normals = has(first_column_of_normals, first_column_of_kernels),
                    .kernels = has(first_column_of_kernels, first_column_of_outward),
                    .outward = has(first_column_of_outward, mixture_column_count)},
                   element.count);
  VertexReader reader(element, attribute_roles(element));
  std::vector<PlyRequest> requests{reader.request};
  const std::vector<std::size_t> columns = rows.layout.columns();
  for (std::size_t k = 0; k < columns.size() && element.count > 0; ++k) {
    if (const std::size_t p = property(mixture_columns[columns[k]]); p < names.size())
      requests.front().sinks.push_back({.property = p, .stride = rows.row_size, .real = rows.values.data() + k});
    else  // only the weight may be missing
      for (std::size_t s = 0; s < element.count; ++s) rows.values[s * rows.row_size + k] = 1;
  }
  if (faces != nullptr) add_face_requests(header, element.count, *faces, requests);
  read_ply_body(file, header, requests);
  const FrameComment comment = find_frame_comment(file, header);
  Mixture mixture = from_rows(rows, comment.frame, comment.sigma0, comment.spacing);
  PointCloud read = reader.finish();
  mixture.colors = std::move(read.colors);
  mixture.scalars = std::move(read.scalars);
  const std::vector<std::string> labels = find_label_comment(header);
  for (ScalarColumn& column : mixture.scalars)
    column.kind =
        std::find(labels.begin(), labels.end(), column.name) != labels.end() ? ScalarKind::label : ScalarKind::quantity;
  return mixture;
}

// What is read from outside must meet the invariants that all stages rely on.
template <class T>
T validated(const InputFile& file, T value) {
  try {
    validate(value);
  } catch (const InvariantError& error) {
    file.fail(error.what());
  }
  return value;
}

}  // namespace

FileKind probe_ply(const InputFile& file) {
  const PlyHeader header = read_ply_header(file);
  const PlyElement* const face = header.find("face");
  const PlyElement* const strips = header.find("tristrips");
  // A mixture never has faces; but point clouds are often written with an empty list of them.
  if (has_covariances(header.vertices())) return face != nullptr ? FileKind::covmesh : FileKind::mixture;
  const bool has_faces = (face != nullptr && face->count > 0) || (strips != nullptr && strips->count > 0);
  return has_faces ? FileKind::mesh : FileKind::points;
}

PointCloud read_ply_points(const InputFile& file) {
  const PlyHeader header = read_ply_header(file);
  VertexReader reader = vertex_reader(file, header);
  read_ply_body(file, header, {reader.request});
  return reader.finish();
}

Mesh read_ply_mesh(const InputFile& file) {
  const PlyHeader header = read_ply_header(file);
  VertexReader reader = vertex_reader(file, header);
  Mesh mesh;
  std::vector<PlyRequest> requests{reader.request};
  add_face_requests(header, reader.request.element->count, mesh.faces, requests);
  read_ply_body(file, header, requests);
  PointCloud vertices = reader.finish();
  mesh.positions = std::move(vertices.positions);
  mesh.normals = std::move(vertices.normals);
  mesh.colors = std::move(vertices.colors);
  for (ScalarColumn& column : vertices.scalars) {
    if (column.name == "sigma")
      mesh.sigma = std::move(column.values);
    else
      mesh.scalars.push_back(std::move(column));
  }
  return mesh;
}

Mixture read_ply_mixture(const InputFile& file) {
  return validated(file, read_gaussians(file, read_ply_header(file), nullptr));
}

CovMesh read_ply_covmesh(const InputFile& file, bool manifold) {
  const PlyHeader header = read_ply_header(file);
  CovMesh mesh;
  mesh.vertices = read_gaussians(file, header, &mesh.faces);
  mesh.rules = find_rules_comment(file, header).value_or(rules_for(mesh.faces));
  if (manifold) return validated(file, std::move(mesh));
  mesh.vertices = validated(file, std::move(mesh.vertices));
  return mesh;
}

}  // namespace gpsrecon::internal::io
