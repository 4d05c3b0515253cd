#include "mesh_target.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace gpsrecon::internal {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 to_point(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

Vec3 to_vec(const Kernel::Point_3& p) {
  return {p.x(), p.y(), p.z()};
}

/// The fans of all faces that have an area, around `center`, so that far coordinates lose nothing.
Triangles triangles_of(const Mesh& mesh, const Vec3& center) {
  Triangles triangles;
  triangles.reserve(mesh.faces.corners.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for_each_triangle(mesh.faces[f], [&](Index i, Index j, Index k) {
      const Vec3 a = mesh.positions[i] - center, b = mesh.positions[j] - center, c = mesh.positions[k] - center;
      if (area_vector(a, b, c).squaredNorm() > 0) triangles.emplace_back(to_point(a), to_point(b), to_point(c));
    });
  return triangles;
}

}  // namespace

struct MeshTarget::Impl {
  Triangles triangles;  // the tree refers to them
  Tree tree;
};

MeshTarget::MeshTarget(const Mesh& mesh) : impl_(std::make_unique<Impl>()) {
  Box3 box;
  for (const Index v : mesh.faces.corners) {
    if (v >= mesh.positions.size())
      throw InvariantError("mesh: vertex index " + std::to_string(v) + " is out of range");
    if (!mesh.positions[v].allFinite()) throw InvariantError("mesh: position " + std::to_string(v) + " is not finite");
    box.extend(mesh.positions[v]);
  }
  if (box.isEmpty()) throw NoSurfaceError("the mesh has no face to scan");
  center_ = box.center();
  diagonal_ = diagonal_length(box);
  impl_->triangles = triangles_of(mesh, center_);
  if (impl_->triangles.empty()) throw NoSurfaceError("the mesh has no face with an area");
  impl_->tree.insert(impl_->triangles.cbegin(), impl_->triangles.cend());
  impl_->tree.build();
}

MeshTarget::~MeshTarget() = default;

std::optional<SurfaceHit> MeshTarget::first_hit(const Vec3& origin, const Vec3& direction) const {
  const Vec3 start = origin - center_;
  const Kernel::Ray_3 ray(to_point(start), Kernel::Vector_3(direction.x(), direction.y(), direction.z()));
  const auto triangle = impl_->tree.first_intersected_primitive(ray);
  if (!triangle) return std::nullopt;
  const Vec3 a = to_vec((*triangle)->vertex(0)), b = to_vec((*triangle)->vertex(1)), c = to_vec((*triangle)->vertex(2));
  const Vec3 normal = area_vector(a, b, c).normalized();
  const double slope = normal.dot(direction);
  if (slope == 0) return std::nullopt;  // the triangle is seen edge-on
  return SurfaceHit{origin + normal.dot(a - start) / slope * direction, normal};
}

}  // namespace gpsrecon::internal
