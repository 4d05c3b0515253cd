// Normals of points as Poisson reconstruction needs them: the plane of the K nearest neighbours, oriented consistently
// along a minimum spanning tree (Hoppe et al. 1992), by CGAL. The tree starts at the highest point, which may be one of
// a few outliers with only each other for neighbours: trees are planted until few points are left, which are left out.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/mst_orient_normals.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

#include <utility>

#include "peer.h"

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using OrientedPoint = std::pair<Kernel::Point_3, Kernel::Vector_3>;

void estimate_normals(const gpsrecon::peer::Arguments& arguments) {
  std::vector<OrientedPoint> points;
  for (const gpsrecon::Vec3& p : gpsrecon::peer::read_finite_points(arguments.in).positions)
    points.emplace_back(Kernel::Point_3(p.x(), p.y(), p.z()), Kernel::Vector_3(0, 0, 0));
  const auto neighbors = static_cast<unsigned>(arguments.number);
  const auto parameters = CGAL::parameters::point_map(CGAL::First_of_pair_property_map<OrientedPoint>())
                              .normal_map(CGAL::Second_of_pair_property_map<OrientedPoint>());
  CGAL::pca_estimate_normals<CGAL::Sequential_tag>(points, neighbors, parameters);
  auto rest = points.begin();
  while (static_cast<std::size_t>(points.end() - rest) > points.size() / 100 + neighbors) {
    auto unreached = CGAL::make_range(rest, points.end());
    const auto reached = CGAL::mst_orient_normals(unreached, neighbors, parameters);
    if (reached == rest) break;
    rest = reached;
  }
  points.erase(rest, points.end());

  gpsrecon::PointCloud result;
  for (const auto& [p, n] : points) {
    result.positions.emplace_back(p.x(), p.y(), p.z());
    // Rounded, so that normals take four bytes a number in the file like the points.
    result.normals.push_back(gpsrecon::Vec3(n.x(), n.y(), n.z()).cast<float>().cast<double>());
  }
  gpsrecon::write_points(result, arguments.out);
}

}  // namespace

int main(int argc, char** argv) {
  return gpsrecon::peer::run(argc, argv, "NEIGHBORS", estimate_normals);
}
