#pragma once

#include <gpsrecon/core/mesh.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

namespace gpsrecon::internal {

/// The mesh of all that edits a manifold surface: half-edges that keep their numbers while others come and go, over
/// points of doubles. Flips, collapses and removals are CGAL's (CGAL/boost/graph/Euler_operations.h). It was measured
/// against OpenMesh (docs/evidence/triangulation.md, "The editable mesh"). Shows CGAL: for sources, not for public
/// headers.
using EditableMesh = CGAL::Surface_mesh<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3>;

/// The mesh of polygons. Vertices and faces have the numbers that they have in the lists; a vertex that no face uses
/// stays isolated. Throws InvariantError, naming the first face or vertex, unless the faces are manifold and
/// consistently oriented. O(n). Precondition: corners are below the number of positions, and no face repeats one.
EditableMesh editable_mesh(const std::vector<Vec3>& positions, const FaceList& faces);

/// The faces as they are now, by their numbers; where nothing was edited, those that were given, corner by corner.
/// `number_of(vertex)` numbers the corners. O(n).
template <class Number>
FaceList face_list(const EditableMesh& mesh, const Number& number_of) {
  FaceList faces;
  faces.reserve(mesh.number_of_faces(), mesh.number_of_halfedges());
  std::vector<Index> corners;
  for (const auto f : mesh.faces()) {
    corners.clear();
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) corners.push_back(number_of(v));
    faces.add(corners);
  }
  return faces;
}

}  // namespace gpsrecon::internal
