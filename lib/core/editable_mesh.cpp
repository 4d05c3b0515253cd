// Half-edges with insertion of single faces: Botsch, Steinberg, Bischoff, Kobbelt 2002 (OpenMesh) and Sieger & Botsch
// 2011 (Surface_mesh), after which CGAL's mesh is made.

#include <gpsrecon/core/editable_mesh.h>

#include <gpsrecon/core/error.h>
#include <string>

namespace gpsrecon::internal {

EditableMesh editable_mesh(const std::vector<Vec3>& positions, const FaceList& faces) {
  using Size = EditableMesh::size_type;
  EditableMesh mesh;
  mesh.reserve(static_cast<Size>(positions.size()), static_cast<Size>(faces.corners.size() / 2 + positions.size()),
               static_cast<Size>(faces.size()));
  for (const Vec3& p : positions) mesh.add_vertex({p.x(), p.y(), p.z()});
  std::vector<EditableMesh::Vertex_index> corners;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    corners.clear();
    for (const Index v : faces[f]) corners.emplace_back(v);
    if (mesh.add_face(corners) == EditableMesh::null_face())
      throw InvariantError("editable mesh: face " + std::to_string(f) + " is not manifold with those before it");
  }
  // Open fans that touch are linked to one another, but a hole beside such a vertex would have no definite boundary.
  std::vector<char> open(positions.size(), 0);
  for (const auto h : mesh.halfedges()) {
    const auto v = static_cast<std::size_t>(mesh.target(h));
    if (mesh.is_border(h) && ++open[v] > 1)
      throw InvariantError("editable mesh: several fans of faces touch in vertex " + std::to_string(v));
  }
  return mesh;
}

}  // namespace gpsrecon::internal
