#include "shape_meshing.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace gpsrecon::internal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertices = CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>;
using Faces =
    CGAL::Triangulation_face_base_with_info_2<int, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertices, Faces>,
                                               CGAL::No_constraint_intersection_tag>;

/// Numbers every face by how many polygons have to be crossed to come to it from outside.
void count_crossings(Triangulation& triangulation) {
  constexpr int unknown = -1;
  for (const auto face : triangulation.all_face_handles()) face->info() = unknown;
  std::vector<Triangulation::Face_handle> here{triangulation.infinite_face()}, beyond;
  for (int crossed = 0; !here.empty(); ++crossed) {
    while (!here.empty()) {
      const auto face = here.back();
      here.pop_back();
      if (face->info() != unknown) continue;
      face->info() = crossed;
      for (int k = 0; k < 3; ++k) (face->is_constrained(k) ? beyond : here).push_back(face->neighbor(k));
    }
    here.swap(beyond);
  }
}

}  // namespace

void add_quad(Mesh& mesh, Index a, Index b, Index c, Index d) {
  if (a != b) mesh.faces.add(a, b, c);
  if (c != d) mesh.faces.add(a, c, d);
}

std::vector<Ring> sweep(Mesh& mesh, const std::vector<Vec2>& chain, const Vec3& axis, std::size_t segments) {
  const Vec3 first = axis.unitOrthogonal(), second = axis.cross(first);
  const bool closed = chain.front() == chain.back();
  std::vector<Ring> rings;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    if (closed && i + 1 == chain.size()) {
      rings.push_back(rings.front());
      break;
    }
    Ring ring;
    const std::size_t size = chain[i].x() == 0 ? 1 : segments;
    for (std::size_t k = 0; k < size; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(segments);
      ring.push_back(static_cast<Index>(mesh.positions.size()));
      mesh.positions.push_back(chain[i].x() * (std::cos(angle) * first + std::sin(angle) * second) +
                               chain[i].y() * axis);
    }
    rings.push_back(std::move(ring));
  }
  const auto at = [](const Ring& ring, std::size_t k) { return ring[k % ring.size()]; };
  for (std::size_t i = 0; i + 1 < rings.size(); ++i)
    for (std::size_t k = 0; k < segments; ++k)
      add_quad(mesh, at(rings[i], k), at(rings[i], k + 1), at(rings[i + 1], k + 1), at(rings[i + 1], k));
  return rings;
}

std::vector<std::array<Index, 3>> triangulate_region(const std::vector<Vec2>& points,
                                                     const std::vector<std::vector<Index>>& polygons) {
  Triangulation triangulation;
  std::vector<Triangulation::Vertex_handle> vertices;
  for (std::size_t i = 0; i < points.size(); ++i) {
    vertices.push_back(triangulation.insert({points[i].x(), points[i].y()},
                                            i == 0 ? Triangulation::Face_handle() : vertices.back()->face()));
    vertices.back()->info() = static_cast<Index>(i);
  }
  for (const std::vector<Index>& polygon : polygons)
    for (std::size_t k = 0; k < polygon.size(); ++k)
      triangulation.insert_constraint(vertices[polygon[k]], vertices[polygon[(k + 1) % polygon.size()]]);
  count_crossings(triangulation);
  std::vector<std::array<Index, 3>> triangles;
  for (const auto face : triangulation.finite_face_handles())
    if (face->info() % 2 == 1)
      triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  return triangles;
}

}  // namespace gpsrecon::internal
