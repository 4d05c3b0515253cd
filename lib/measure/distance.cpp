#include <gpsrecon/measure/distance.h>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/hilbert_sort.h>
#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/parallel.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;

/// A triangle is treated as its three edges when its height is below this share of its longest edge: its normal, and
/// with it the foot of the perpendicular, is mostly rounding then, and the edges are that close anyway.
constexpr double sliver_ratio = 1e-10;

/// Farther from the surface than this many times its size squares of squares would overflow.
constexpr double farthest = 1e70;

Point to_point(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

Vec3 to_vec(const Point& p) {
  return {p.x(), p.y(), p.z()};
}

/// A triangle as CGAL's tree knows it (concept AABBPrimitiveWithSharedData): the positions of its corners are looked up
/// in the array that all triangles share.
class Triangle {
 public:
  using Id = Index;
  using Point = gpsrecon::Point;
  using Datum = Kernel::Triangle_3;
  using Point_reference = Point;
  using Datum_reference = Datum;
  using Shared_data = const Vec3*;
  static Shared_data construct_shared_data(const Vec3* positions) { return positions; }

  Triangle(Index a, Index b, Index c, Index face) : corners_{a, b, c}, face_(face) {}
  Id id() const { return face_; }
  const Vec3& corner(std::size_t k, const Vec3* positions) const { return positions[corners_[k]]; }
  Point reference_point(const Vec3* positions) const { return to_point(corner(0, positions)); }
  Datum datum(const Vec3* positions) const {
    return {to_point(corner(0, positions)), to_point(corner(1, positions)), to_point(corner(2, positions))};
  }

 private:
  std::array<Index, 3> corners_;
  Index face_;
};

Vec3 nearest_on_segment(const Vec3& query, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double along = d.dot(query - a), length2 = d.squaredNorm();
  if (!(along > 0)) return a;
  return along >= length2 ? b : Vec3(a + along / length2 * d);
}

/// Barycentric coordinates of the foot of the perpendicular are volumes built from edges, so they lose nothing when the
/// triangle is small against its distance, and a convex combination is a point of the triangle whatever their rounding:
/// it bounds the distance of the next query, too. Where a coordinate is negative the nearest point lies on one of the
/// edges opposite to the corners with negative coordinates.
Vec3 nearest_on_triangle(const Vec3& query, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, bc = c - b, ca = a - c;
  const Vec3 normal = ca.cross(ab);
  const double longest2 = std::max({ab.squaredNorm(), bc.squaredNorm(), ca.squaredNorm()});
  const bool sliver = !(normal.squaredNorm() > sliver_ratio * sliver_ratio * longest2 * longest2);
  const double wa = normal.dot((b - query).cross(bc)), wb = normal.dot((c - query).cross(ca)),
               wc = normal.dot((a - query).cross(ab));
  const double sum = wa + wb + wc;
  if (!sliver && wa >= 0 && wb >= 0 && wc >= 0 && sum > 0) return wa / sum * a + wb / sum * b + wc / sum * c;

  Vec3 best = a;
  double best2 = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Vec3& start, const Vec3& end) {
    const Vec3 p = nearest_on_segment(query, start, end);
    const double p2 = (p - query).squaredNorm();
    if (p2 < best2) best = p, best2 = p2;
  };
  if (sliver || wa < 0) consider(b, c);
  if (sliver || wb < 0) consider(c, a);
  if (sliver || wc < 0) consider(a, b);
  return best;
}

/// CGAL's projection onto a triangle goes through its plane, which loses digits where the triangle is a needle or the
/// query is far away; this one does not.
struct Traits : CGAL::AABB_traits<Kernel, Triangle> {
  struct NearestPoint {
    const Vec3* positions;
    Point operator()(const Point& query, const Triangle& t, const Point& bound) const {
      const Vec3 q = to_vec(query);
      const Vec3 p = nearest_on_triangle(q, t.corner(0, positions), t.corner(1, positions), t.corner(2, positions));
      return (p - q).squaredNorm() < (to_vec(bound) - q).squaredNorm() ? to_point(p) : bound;
    }
  };
  NearestPoint closest_point_object() const { return {shared_data()}; }
};

using Tree = CGAL::AABB_tree<Traits>;
using Hint = Tree::Point_and_primitive_id;

}  // namespace

/// The tree works in units of the surface: its bounding box, moved to the origin, fits [-1, 1]³. Coordinates far from
/// the origin lose nothing then, and tiny or huge units neither underflow nor overflow.
struct SurfaceDistance::Impl {
  Vec3 center = Vec3::Zero();
  double to_unit = 1;           // a power of two
  std::vector<Vec3> positions;  // in units; the tree refers to them
  Tree tree;
  Hint start;  // some point of the surface

  void set_units(const Mesh& mesh);
  void insert_fans(const FaceList& faces);
  Vec3 in_units(const Vec3& p) const { return (p - center) * to_unit; }
  ClosestPoint result(const Point& query, const Hint& nearest) const;
};

void SurfaceDistance::Impl::set_units(const Mesh& mesh) {
  const Box3 box = bounding_box(mesh.positions, mesh.faces.corners);
  center = box.min() + box.diagonal() / 2;
  const double radius = std::max((box.max() - center).maxCoeff(), (center - box.min()).maxCoeff());
  int exponent = 0;
  if (radius > 0) std::frexp(radius, &exponent);
  to_unit = std::ldexp(1.0, -std::clamp(exponent, -1000, 1000));
}

void SurfaceDistance::Impl::insert_fans(const FaceList& faces) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    for_each_triangle(face, [&](Index a, Index b, Index c) { tree.insert(Triangle(a, b, c, static_cast<Index>(f))); });
    if (face.size() > 2) start = {to_point(positions[face[0]]), static_cast<Index>(f)};
  }
}

ClosestPoint SurfaceDistance::Impl::result(const Point& query, const Hint& nearest) const {
  const Vec3 p = to_vec(nearest.first);
  return {(p - to_vec(query)).norm() / to_unit, center + p / to_unit, nearest.second};
}

SurfaceDistance::SurfaceDistance(const Mesh& mesh, const RunContext& context) : impl_(std::make_unique<Impl>()) {
  for (const Index v : mesh.faces.corners) {
    if (v >= mesh.positions.size())
      throw InvariantError("mesh: vertex index " + std::to_string(v) + " is out of range");
    if (!mesh.positions[v].allFinite()) throw InvariantError("mesh: position " + std::to_string(v) + " is not finite");
  }
  if (mesh.faces.corners.empty()) return;
  impl_->set_units(mesh);
  impl_->positions.resize(mesh.positions.size());
  parallel_for(mesh.positions.size(), context,
               [&](std::size_t v) { impl_->positions[v] = impl_->in_units(mesh.positions[v]); });
  impl_->insert_fans(mesh.faces);
  context.throw_if_cancelled();
  // A query would build the tree, too, but not from several threads at once without waiting.
  impl_->tree.build(impl_->positions.data());
}

SurfaceDistance::~SurfaceDistance() = default;
SurfaceDistance::SurfaceDistance(SurfaceDistance&&) noexcept = default;
SurfaceDistance& SurfaceDistance::operator=(SurfaceDistance&&) noexcept = default;

std::size_t SurfaceDistance::triangle_count() const {
  return impl_->tree.size();
}

ClosestPoint SurfaceDistance::closest(const Vec3& query) const {
  const Point q = to_point(impl_->in_units(query));
  return impl_->result(q, impl_->tree.closest_point_and_primitive(q, impl_->start));
}

namespace {

/// The points along a Hilbert curve: neighbours in the order are neighbours in space, so the last answer is a good
/// bound for the next query, and the tree's nodes are still in the cache.
std::vector<std::size_t> visiting_order(const std::vector<Point>& points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  using Map = CGAL::Pointer_property_map<Point>::const_type;
  const CGAL::Spatial_sort_traits_adapter_3<Kernel, Map> traits(CGAL::make_property_map(points));
  CGAL::hilbert_sort(order.begin(), order.end(), traits);
  return order;
}

}  // namespace

std::vector<ClosestPoint> SurfaceDistance::distances(std::span<const Vec3> points, const RunContext& context) const {
  if (points.empty()) return {};
  if (empty()) throw InvariantError("distances: the surface has no faces");
  std::vector<Point> queries(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 q = impl_->in_units(points[i]);
    if (!(q.cwiseAbs().maxCoeff() <= farthest))
      throw InvariantError("distances: point " + std::to_string(i) +
                           " is not finite or immensely far from the surface");
    queries[i] = to_point(q);
  }
  const std::vector<std::size_t> order = visiting_order(queries);
  std::vector<ClosestPoint> results(points.size());
  constexpr std::size_t block_size = 1024;
  parallel_blocks(
      points.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        Hint hint = impl_->start;
        for (std::size_t i = begin; i < end; ++i) {
          const Point& query = queries[order[i]];
          hint = impl_->tree.closest_point_and_primitive(query, hint);
          results[order[i]] = impl_->result(query, hint);
        }
      },
      block_size);
  return results;
}

}  // namespace gpsrecon
