#include <gpsrecon/core/mesh.h>

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/error.h>
#include <algorithm>

namespace gpsrecon {
void validate(const FaceList& faces, std::size_t vertex_count) {
  std::vector<Index> sorted;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    if (face.size() < 3) throw InvariantError("mesh: face " + std::to_string(f) + " has fewer than three corners");
    for (const Index v : face)
      if (v >= vertex_count)
        throw InvariantError("mesh: face " + std::to_string(f) + " refers to vertex " + std::to_string(v) + " of " +
                             std::to_string(vertex_count));
    sorted.assign(face.begin(), face.end());
    std::sort(sorted.begin(), sorted.end());
    if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
      throw InvariantError("mesh: face " + std::to_string(f) + " repeats vertex " + std::to_string(*twice));
  }
}

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
  validate(mesh.faces, n);
}

SurfaceRules rules_for(const FaceList& faces) {
  return {.scheme = faces.is_triangular() ? Scheme::loop : Scheme::catmull_clark};
}

void validate(const CovMesh& mesh) {
  validated_connectivity(mesh);
}

}  // namespace gpsrecon
