// Weighted locally optimal projection of a third of the points, 15 iterations, by CGAL (Huang et al. 2009). The number
// is the radius within which neighbours count. Its attraction divides by no distance, and every particle repels every
// other in reach in all iterations: another operator than ours, of comparable work.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/wlop_simplify_and_regularize_point_set.h>

#include <iterator>
#include <vector>

#include "peer.h"

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

void project(const gpsrecon::peer::Arguments& arguments) {
  std::vector<Kernel::Point_3> points, particles;
  for (const gpsrecon::Vec3& p : gpsrecon::peer::read_finite_points(arguments.in).positions)
    points.emplace_back(p.x(), p.y(), p.z());
  constexpr double percentage = 100.0 / 3;
  constexpr unsigned iterations = 15;
  CGAL::wlop_simplify_and_regularize_point_set<CGAL::Sequential_tag>(points, std::back_inserter(particles),
                                                                     CGAL::parameters::select_percentage(percentage)
                                                                         .neighbor_radius(arguments.number)
                                                                         .number_of_iterations(iterations));
  gpsrecon::PointCloud result;
  for (const Kernel::Point_3& p : particles) result.positions.emplace_back(p.x(), p.y(), p.z());
  gpsrecon::write_points(result, arguments.out);
}

}  // namespace

int main(int argc, char** argv) {
  return gpsrecon::peer::run(argc, argv, "RADIUS", project);
}
