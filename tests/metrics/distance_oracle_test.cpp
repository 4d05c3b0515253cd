#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <gpsrecon/metrics/distance.h>
#include <gtest/gtest.h>

#include "shapes.h"

namespace gpsrecon::test {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Triangles::iterator>>>;

TEST(DistanceOracle, AgreesWithAnotherTree) {
  Mesh mesh = sphere(6);
  Uniform uniform(21);
  for (Vec3& p : mesh.positions) p = (1 + uniform(-0.02, 0.02)) * p;
  Triangles triangles;
  const auto point = [](const Vec3& p) { return Point(p.x(), p.y(), p.z()); };
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    triangles.emplace_back(point(mesh.positions[face[0]]), point(mesh.positions[face[1]]),
                           point(mesh.positions[face[2]]));
  }
  Tree tree(triangles.begin(), triangles.end());
  tree.accelerate_distance_queries();

  std::vector<Vec3> points;
  for (int i = 0; i < 15000; ++i) points.push_back(uniform.vector(-1.1, 1.1));
  for (int i = 0; i < 15000; ++i) points.push_back((1 + uniform(-0.03, 0.03)) * uniform.vector().normalized());
  const auto found = SurfaceDistance(mesh).distances(points);
  for (std::size_t i = 0; i < points.size(); ++i)
    ASSERT_NEAR(found[i].distance, std::sqrt(tree.squared_distance(point(points[i]))), 1e-13) << i;
}

}  // namespace
}  // namespace gpsrecon::test
