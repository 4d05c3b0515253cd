// Poisson reconstruction of points with normals by CGAL (a Delaunay triangulation instead of an octree, without
// screening), with CGAL's defaults.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/compute_average_spacing.h>
#include <CGAL/poisson_surface_reconstruction.h>
#include <CGAL/property_map.h>

#include <utility>

#include "peer.h"

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using OrientedPoint = std::pair<Kernel::Point_3, Kernel::Vector_3>;
using PointMap = CGAL::First_of_pair_property_map<OrientedPoint>;
using NormalMap = CGAL::Second_of_pair_property_map<OrientedPoint>;

void reconstruct(const gpsrecon::peer::Arguments& arguments) {
  std::vector<OrientedPoint> points;
  {
    const gpsrecon::PointCloud cloud = gpsrecon::peer::read_points_with_normals(arguments.in);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const gpsrecon::Vec3 &p = cloud.positions[i], &n = cloud.normals[i];
      points.emplace_back(Kernel::Point_3(p.x(), p.y(), p.z()), Kernel::Vector_3(n.x(), n.y(), n.z()));
    }
  }
  const double spacing =
      CGAL::compute_average_spacing<CGAL::Sequential_tag>(points, 6, CGAL::parameters::point_map(PointMap()));
  CGAL::Surface_mesh<Kernel::Point_3> surface;
  if (!CGAL::poisson_surface_reconstruction_delaunay(points.begin(), points.end(), PointMap(), NormalMap(), surface,
                                                     spacing))
    throw std::runtime_error("CGAL found no surface");

  gpsrecon::Mesh mesh;
  for (const auto vertex : surface.vertices()) {
    const Kernel::Point_3& p = surface.point(vertex);
    mesh.positions.emplace_back(p.x(), p.y(), p.z());
  }
  std::vector<gpsrecon::Index> corners;
  for (const auto face : surface.faces()) {
    corners.clear();
    for (const auto vertex : surface.vertices_around_face(surface.halfedge(face)))
      corners.push_back(static_cast<gpsrecon::Index>(static_cast<std::size_t>(vertex)));
    mesh.faces.add(corners);
  }
  gpsrecon::write_mesh(mesh, arguments.out);
}

}  // namespace

int main(int argc, char** argv) {
  return gpsrecon::peer::run(argc, argv, nullptr, reconstruct);
}
