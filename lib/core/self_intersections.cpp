// Box intersection by streamed segment trees: Zomorodian & Edelsbrunner 2002 (CGAL), then exact predicates.

#include <gpsrecon/core/self_intersections.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace gpsrecon::internal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

struct Triangle {
  std::array<Index, 3> corners;
  Index face;
};

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, Index>;

class Intersections {
 public:
  Intersections(std::span<const Vec3> positions, const std::vector<Triangle>& triangles)
      : positions_(positions), triangles_(triangles) {}

  Point point(Index v) const { return {positions_[v].x(), positions_[v].y(), positions_[v].z()}; }
  Kernel::Triangle_3 triangle(Index t) const {
    const auto& c = triangles_[t].corners;
    return {point(c[0]), point(c[1]), point(c[2])};
  }

  /// Elsewhere than in what they share.
  bool intersect(Index s, Index t) const {
    std::array<Index, 3> a = triangles_[s].corners, b = triangles_[t].corners;
    // Shared corners to the front, in the same order.
    std::size_t shared = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = shared; j < 3; ++j)
        if (a[i] == b[j]) {
          std::swap(b[shared], b[j]);
          std::swap(a[shared], a[i]);
          ++shared;
          break;
        }
    switch (shared) {
      case 0:
        return CGAL::do_intersect(triangle(s), triangle(t));
      case 1:  // beyond the corner they can only meet on the side opposite to it of one of them
        return CGAL::do_intersect(Kernel::Segment_3(point(a[1]), point(a[2])), triangle(t)) ||
               CGAL::do_intersect(Kernel::Segment_3(point(b[1]), point(b[2])), triangle(s));
      case 2:  // folded flat onto each other
        return CGAL::coplanar(point(a[0]), point(a[1]), point(a[2]), point(b[2])) &&
               CGAL::coplanar_orientation(point(a[0]), point(a[1]), point(a[2]), point(b[2])) == CGAL::POSITIVE;
      default:
        return true;
    }
  }

 private:
  std::span<const Vec3> positions_;
  const std::vector<Triangle>& triangles_;
};

std::vector<Triangle> triangles_with_area(std::span<const Vec3> positions, const FaceList& faces) {
  for (const Index v : faces.corners)
    if (v >= positions.size() || !positions[v].allFinite())
      throw InvariantError("mesh: corner " + std::to_string(v) + " is out of range or not finite");
  const auto point = [&](Index v) { return Point(positions[v].x(), positions[v].y(), positions[v].z()); };
  std::vector<Triangle> triangles;
  triangles.reserve(faces.corners.size() - 2 * std::min(faces.size(), faces.corners.size() / 2));
  for (std::size_t f = 0; f < faces.size(); ++f)
    for_each_triangle(faces[f], [&](Index a, Index b, Index c) {
      if (!CGAL::collinear(point(a), point(b), point(c))) triangles.push_back({{a, b, c}, static_cast<Index>(f)});
    });
  return triangles;
}

}  // namespace

std::vector<Index> self_intersecting_faces(std::span<const Vec3> positions, const FaceList& faces,
                                           const RunContext& context) {
  const std::vector<Triangle> triangles = triangles_with_area(positions, faces);
  const Intersections test(positions, triangles);
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (Index t = 0; t < triangles.size(); ++t) boxes.emplace_back(test.triangle(t).bbox(), t);
  std::vector<std::pair<Index, Index>> pairs;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
    if (triangles[a.info()].face != triangles[b.info()].face) pairs.emplace_back(a.info(), b.info());
  });
  std::vector<char> hit(pairs.size(), 0);
  parallel_for(pairs.size(), context,
               [&](std::size_t i) { hit[i] = test.intersect(pairs[i].first, pairs[i].second) ? 1 : 0; });
  std::vector<char> marked(faces.size(), 0);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (hit[i]) marked[triangles[pairs[i].first].face] = marked[triangles[pairs[i].second].face] = 1;
  std::vector<Index> found;
  for (Index f = 0; f < marked.size(); ++f)
    if (marked[f]) found.push_back(f);
  return found;
}

}  // namespace gpsrecon::internal
