// Advancing front reconstruction (Cohen-Steiner and Da 2004) of points without normals by CGAL, with CGAL's defaults.
// The surface interpolates the points.

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <array>
#include <iterator>

#include "peer.h"

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

void reconstruct(const gpsrecon::peer::Arguments& arguments) {
  gpsrecon::Mesh mesh;
  mesh.positions = gpsrecon::peer::read_finite_points(arguments.in).positions;
  std::vector<Kernel::Point_3> points;
  for (const gpsrecon::Vec3& p : mesh.positions) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::array<std::size_t, 3>> faces;
  CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(), std::back_inserter(faces));
  for (const auto& [a, b, c] : faces)
    mesh.faces.add(static_cast<gpsrecon::Index>(a), static_cast<gpsrecon::Index>(b), static_cast<gpsrecon::Index>(c));
  gpsrecon::write_mesh(mesh, arguments.out);
}

}  // namespace

int main(int argc, char** argv) {
  return gpsrecon::peer::run(argc, argv, nullptr, reconstruct);
}
