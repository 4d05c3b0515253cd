#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mesh_topology.h>
#include <algorithm>

namespace gpsrecon {
namespace {

void validate_faces(const FaceList& faces, std::size_t vertex_count) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    if (face.size() < 3) throw InvariantError("mesh: face " + std::to_string(f) + " has fewer than three corners");
    for (std::size_t k = 0; k < face.size(); ++k) {
      if (face[k] >= vertex_count)
        throw InvariantError("mesh: face " + std::to_string(f) + " refers to vertex " + std::to_string(face[k]) +
                             " of " + std::to_string(vertex_count));
      if (std::find(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(k), face[k]) !=
          face.begin() + static_cast<std::ptrdiff_t>(k))
        throw InvariantError("mesh: face " + std::to_string(f) + " repeats vertex " + std::to_string(face[k]));
    }
  }
}

}  // namespace

void validate(const Mesh& mesh) {
  const std::size_t n = mesh.positions.size();
  const auto check = [n](std::size_t length, const char* attribute) {
    if (length != 0 && length != n)
      throw InvariantError(std::string("mesh: ") + attribute + " must be absent or one per vertex");
  };
  check(mesh.normals.size(), "normals");
  check(mesh.colors.size(), "colors");
  check(mesh.sigma.size(), "sigma");
  check(mesh.covariances.size(), "covariances");
  for (const ScalarColumn& column : mesh.scalars) check(column.values.size(), column.name.c_str());
  for (std::size_t i = 0; i < n; ++i)
    if (!mesh.positions[i].allFinite()) throw InvariantError("mesh: position " + std::to_string(i) + " is not finite");
  validate_faces(mesh.faces, n);
}

void validate(const CovMesh& mesh) {
  validate(mesh.vertices);
  validate_faces(mesh.faces, mesh.vertices.size());
  const Topology t = topology(mesh.faces, mesh.vertices.size());
  if (!t.manifold()) {
    const std::vector<Index> fans =
        vertex_fans(mesh.faces, half_edges(mesh.faces, mesh.vertices.size()), mesh.vertices.size());
    const auto first = std::find_if(fans.begin(), fans.end(), [](Index count) { return count > 1; });
    throw InvariantError(
        "covariance mesh: " + std::to_string(t.nonmanifold_edges) + " non-manifold edges, " +
        std::to_string(t.nonmanifold_vertices) + " non-manifold vertices, " + std::to_string(t.inconsistent_edges) +
        " inconsistently oriented edges" +
        (first == fans.end() ? "" : "; the first such vertex is " + std::to_string(first - fans.begin())));
  }
}

}  // namespace gpsrecon
