#include <gpsrecon/core/error.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/metrics/distance.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace gpsrecon {
namespace {

using Corners = std::array<Index, 3>;

/// Triangles per leaf are this many or, where the number of leaves had to be rounded up to a power of two, down to
/// half.
constexpr std::size_t leaf_size = 4;

/// A triangle is treated as its three edges when its height is below this share of its longest edge: its normal, and
/// with it the foot of the perpendicular, is mostly rounding then, and the edges are that close anyway.
constexpr double sliver_ratio = 1e-10;

/// Farther from the surface than this many times its size squares of squares would overflow.
constexpr double farthest = 1e70;

/// Boxes are kept in single precision, in coordinates with |x| <= 1. Widening by more than the rounding of box and
/// query keeps every bound below the true distance; the relative part covers queries far outside.
constexpr double box_margin = 0x1p-22;
constexpr float bound_slack = 1.0f + 1e-5f;

struct Box {
  std::array<float, 3> low, high;
};

/// The boxes of both children, which are always tested together.
struct Node {
  std::array<Box, 2> child;
};

float squared_distance(const Box& box, const std::array<float, 3>& x) {
  float sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const float d = std::max(0.0f, std::max(box.low[k] - x[k], x[k] - box.high[k]));
    sum += d * d;
  }
  return sum;
}

Box merged(const Box& a, const Box& b) {
  Box box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.low[k] = std::min(a.low[k], b.low[k]);
    box.high[k] = std::max(a.high[k], b.high[k]);
  }
  return box;
}

/// The point of the segment from a to a + d nearest to the origin.
Vec3 nearest_on_segment(const Vec3& a, const Vec3& d) {
  const double length2 = d.squaredNorm();
  const double along = -a.dot(d);
  if (!(along > 0) || !(length2 > 0)) return a;
  return along >= length2 ? Vec3(a + d) : Vec3(a + along / length2 * d);
}

/// The point of the triangle nearest to the origin. Barycentric coordinates of the foot of the perpendicular are
/// volumes built from edges, so they lose nothing when the triangle is small against its distance. A convex combination
/// is a point of the triangle whatever their rounding, so the distance is never too small. Where a coordinate is
/// negative the nearest point lies on one of the edges opposite to the corners with negative coordinates.
Vec3 nearest_on_triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, bc = c - b, ca = a - c;
  const Vec3 normal = ca.cross(ab);
  const double longest2 = std::max({ab.squaredNorm(), bc.squaredNorm(), ca.squaredNorm()});
  const bool sliver = !(normal.squaredNorm() > sliver_ratio * sliver_ratio * longest2 * longest2);
  const double wa = normal.dot(b.cross(bc)), wb = normal.dot(c.cross(ca)), wc = normal.dot(a.cross(ab));
  if (!sliver && wa >= 0 && wb >= 0 && wc >= 0) return (wa * a + wb * b + wc * c) / (wa + wb + wc);

  Vec3 best = a;
  double best2 = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Vec3& start, const Vec3& edge) {
    const Vec3 p = nearest_on_segment(start, edge);
    const double p2 = p.squaredNorm();
    if (p2 < best2) best = p, best2 = p2;
  };
  if (sliver || wa < 0) consider(b, bc);
  if (sliver || wb < 0) consider(c, ca);
  if (sliver || wc < 0) consider(a, ab);
  return best;
}

/// Interleaves the lower 21 bits of three numbers.
std::uint64_t morton_code(const std::array<std::uint32_t, 3>& cell) {
  std::uint64_t code = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    std::uint64_t x = cell[k] & 0x1FFFFFu;
    x = (x | x << 32) & 0x1F00000000FFFFull;
    x = (x | x << 16) & 0x1F0000FF0000FFull;
    x = (x | x << 8) & 0x100F00F00F00F00Full;
    x = (x | x << 4) & 0x10C30C30C30C30C3ull;
    x = (x | x << 2) & 0x1249249249249249ull;
    code |= x << k;
  }
  return code;
}

std::vector<Corners> fan_triangles(const FaceList& faces, std::vector<Index>& face_of) {
  std::vector<Corners> triangles;
  triangles.reserve(faces.corners.size() - std::min(faces.corners.size(), 2 * faces.size()));
  face_of.reserve(triangles.capacity());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    for (std::size_t k = 2; k < face.size(); ++k) {
      triangles.push_back({face[0], face[k - 1], face[k]});
      face_of.push_back(static_cast<Index>(f));
    }
  }
  return triangles;
}

}  // namespace

/// Node i has the children 2i and 2i + 1, the root is 1; numbers from leaf_count on are leaves. Leaf l holds the
/// triangles [first(l), first(l + 1)), so that the tree needs no pointers.
struct SurfaceDistance::Impl {
  std::vector<Vec3> positions;
  std::vector<Corners> triangles;  // in tree order
  std::vector<Index> face_of;      // per triangle
  std::vector<Node> nodes;         // of size leaf_count; entry 0 is not used
  std::size_t leaf_count = 1;
  Vec3 center = Vec3::Zero();
  double to_unit = 1;  // a power of two that brings the bounding box into [-1, 1]³

  std::size_t first(std::size_t leaf) const { return triangles.size() * leaf / leaf_count; }

  void set_units();
  void sort_triangles(const RunContext& context);
  void split(std::vector<Index>& order, const std::vector<std::array<float, 3>>& centroids, std::size_t leaf,
             std::size_t leaf_end) const;
  void compute_boxes(const RunContext& context);
  Box leaf_box(std::size_t leaf) const;

  Vec3 offset(std::size_t triangle, const Vec3& query) const;
  std::size_t nearest(const Vec3& query, std::size_t hint, Vec3& best) const;
  ClosestPoint result(const Vec3& query, std::size_t triangle, const Vec3& offset) const;
};

void SurfaceDistance::Impl::set_units() {
  Vec3 low = positions[triangles[0][0]], high = low;
  for (const Corners& t : triangles)
    for (const Index v : t) {
      low = low.cwiseMin(positions[v]);
      high = high.cwiseMax(positions[v]);
    }
  center = low + (high - low) / 2;
  const double radius = std::max((high - center).maxCoeff(), (center - low).maxCoeff());
  int exponent = 0;
  if (radius > 0) std::frexp(radius, &exponent);
  to_unit = std::ldexp(1.0, -std::clamp(exponent, -1000, 1000));
}

void SurfaceDistance::Impl::split(std::vector<Index>& order, const std::vector<std::array<float, 3>>& centroids,
                                  std::size_t leaf, std::size_t leaf_end) const {
  if (leaf_end - leaf <= 1) return;
  const std::size_t middle_leaf = leaf + (leaf_end - leaf) / 2;
  const std::size_t begin = first(leaf), middle = first(middle_leaf), end = first(leaf_end);
  std::array<float, 3> low = centroids[order[begin]], high = low;
  for (std::size_t i = begin; i < end; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], centroids[order[i]][k]);
      high[k] = std::max(high[k], centroids[order[i]][k]);
    }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  const auto at = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [&](Index a, Index b) { return centroids[a][axis] < centroids[b][axis]; });
}

/// Halves the triangles at the median along the longest side of their centroids' box, again and again.
void SurfaceDistance::Impl::sort_triangles(const RunContext& context) {
  while (leaf_count * leaf_size < triangles.size()) leaf_count *= 2;
  std::vector<std::array<float, 3>> centroids(triangles.size());
  parallel_for(triangles.size(), context, [&](std::size_t i) {
    const Corners& t = triangles[i];
    Vec3 sum = Vec3::Zero();
    for (const Index v : t) sum += (positions[v] - center) * to_unit;
    for (int k = 0; k < 3; ++k) centroids[i][static_cast<std::size_t>(k)] = static_cast<float>(sum[k]);
  });
  std::vector<Index> order(triangles.size());
  std::iota(order.begin(), order.end(), Index{0});

  // The ranges of one level are independent; below the first few levels each task takes a whole subtree.
  constexpr std::size_t tasks = 32;
  std::size_t ranges = 1;
  for (; ranges < std::min(tasks, leaf_count); ranges *= 2)
    parallel_for(
        ranges, context,
        [&](std::size_t r) { split(order, centroids, leaf_count * r / ranges, leaf_count * (r + 1) / ranges); }, 1);
  parallel_for(
      ranges, context,
      [&](std::size_t r) {
        const std::size_t leaf_begin = leaf_count * r / ranges, leaf_end = leaf_count * (r + 1) / ranges;
        for (std::size_t width = leaf_end - leaf_begin; width > 1; width /= 2)
          for (std::size_t leaf = leaf_begin; leaf < leaf_end; leaf += width)
            split(order, centroids, leaf, leaf + width);
      },
      1);

  std::vector<Corners> sorted_triangles(triangles.size());
  std::vector<Index> sorted_faces(triangles.size());
  parallel_for(triangles.size(), context, [&](std::size_t i) {
    sorted_triangles[i] = triangles[order[i]];
    sorted_faces[i] = face_of[order[i]];
  });
  triangles = std::move(sorted_triangles);
  face_of = std::move(sorted_faces);
}

Box SurfaceDistance::Impl::leaf_box(std::size_t leaf) const {
  Vec3 low = positions[triangles[first(leaf)][0]], high = low;
  for (std::size_t i = first(leaf); i < first(leaf + 1); ++i)
    for (const Index v : triangles[i]) {
      low = low.cwiseMin(positions[v]);
      high = high.cwiseMax(positions[v]);
    }
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[static_cast<std::size_t>(k)] = static_cast<float>((low[k] - center[k]) * to_unit - box_margin);
    box.high[static_cast<std::size_t>(k)] = static_cast<float>((high[k] - center[k]) * to_unit + box_margin);
  }
  return box;
}

void SurfaceDistance::Impl::compute_boxes(const RunContext& context) {
  nodes.resize(leaf_count);
  if (leaf_count == 1) return;
  parallel_for(leaf_count, context,
               [&](std::size_t leaf) { nodes[(leaf_count + leaf) / 2].child[leaf % 2] = leaf_box(leaf); });
  for (std::size_t i = leaf_count - 1; i > 1; --i)
    nodes[i / 2].child[i % 2] = merged(nodes[i].child[0], nodes[i].child[1]);
}

/// From the query to the nearest point of a triangle, in unit lengths. Only differences are scaled, so coordinates far
/// from the origin lose nothing, and tiny or huge units neither underflow nor overflow.
Vec3 SurfaceDistance::Impl::offset(std::size_t triangle, const Vec3& query) const {
  const Corners& t = triangles[triangle];
  return nearest_on_triangle((positions[t[0]] - query) * to_unit, (positions[t[1]] - query) * to_unit,
                             (positions[t[2]] - query) * to_unit);
}

/// Returns the nearest triangle, starting from the distance of triangle `hint`; `best` is its offset.
std::size_t SurfaceDistance::Impl::nearest(const Vec3& query, std::size_t hint, Vec3& best) const {
  struct Pending {
    std::size_t node;
    float bound;
  };
  std::array<Pending, 64> stack;
  std::size_t depth = 0, nearest_triangle = hint;
  best = offset(hint, query);
  double best2 = best.squaredNorm();
  float limit = static_cast<float>(best2) * bound_slack;
  const Vec3 unit = (query - center) * to_unit;
  const std::array<float, 3> x{static_cast<float>(unit.x()), static_cast<float>(unit.y()),
                               static_cast<float>(unit.z())};
  stack[depth++] = {1, 0.0f};
  while (depth > 0) {
    auto [node, bound] = stack[--depth];
    while (bound <= limit && node < leaf_count) {
      float bounds[2] = {squared_distance(nodes[node].child[0], x), squared_distance(nodes[node].child[1], x)};
      const std::size_t near_side = bounds[1] < bounds[0] ? 1 : 0, far_side = 1 - near_side;
      if (bounds[far_side] <= limit) stack[depth++] = {2 * node + far_side, bounds[far_side]};
      bound = bounds[near_side];
      node = 2 * node + near_side;
    }
    if (!(bound <= limit)) continue;
    const std::size_t leaf = node - leaf_count;
    for (std::size_t i = first(leaf), end = first(leaf + 1); i < end; ++i) {
      const Vec3 candidate = offset(i, query);
      const double candidate2 = candidate.squaredNorm();
      if (candidate2 > best2 || (candidate2 == best2 && face_of[i] >= face_of[nearest_triangle])) continue;
      nearest_triangle = i;
      best = candidate;
      best2 = candidate2;
      limit = static_cast<float>(best2) * bound_slack;
    }
  }
  return nearest_triangle;
}

ClosestPoint SurfaceDistance::Impl::result(const Vec3& query, std::size_t triangle, const Vec3& best) const {
  return {best.norm() / to_unit, query + best / to_unit, face_of[triangle]};
}

SurfaceDistance::SurfaceDistance(const Mesh& mesh, const RunContext& context) : impl_(std::make_unique<Impl>()) {
  for (const Index v : mesh.faces.corners) {
    if (v >= mesh.positions.size())
      throw InvariantError("mesh: vertex index " + std::to_string(v) + " is out of range");
    if (!mesh.positions[v].allFinite()) throw InvariantError("mesh: position " + std::to_string(v) + " is not finite");
  }
  impl_->positions = mesh.positions;
  impl_->triangles = fan_triangles(mesh.faces, impl_->face_of);
  if (impl_->triangles.empty()) return;
  impl_->set_units();
  impl_->sort_triangles(context);
  impl_->compute_boxes(context);
}

SurfaceDistance::~SurfaceDistance() = default;
SurfaceDistance::SurfaceDistance(SurfaceDistance&&) noexcept = default;
SurfaceDistance& SurfaceDistance::operator=(SurfaceDistance&&) noexcept = default;

std::size_t SurfaceDistance::triangle_count() const {
  return impl_->triangles.size();
}

ClosestPoint SurfaceDistance::closest(const Vec3& query) const {
  Vec3 best;
  const std::size_t triangle = impl_->nearest(query, 0, best);
  return impl_->result(query, triangle, best);
}

namespace {

/// The points along a Morton curve through their bounding box: neighbours in the order are neighbours in space, so the
/// last answer is a good bound for the next query, and the tree's nodes are still in the cache.
std::vector<Index> visiting_order(std::span<const Vec3> points, const RunContext& context) {
  Vec3 low = points[0], high = points[0];
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double size = (high - low).maxCoeff();
  std::vector<std::pair<std::uint64_t, Index>> keys(points.size());
  parallel_for(points.size(), context, [&](std::size_t i) {
    std::array<std::uint32_t, 3> cell{};
    if (size > 0)
      for (int k = 0; k < 3; ++k)
        cell[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>((points[i][k] - low[k]) / size * 0x1FFFFF);
    keys[i] = {morton_code(cell), static_cast<Index>(i)};
  });
  std::sort(keys.begin(), keys.end());
  std::vector<Index> order(points.size());
  for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
  return order;
}

}  // namespace

std::vector<ClosestPoint> SurfaceDistance::distances(std::span<const Vec3> points, const RunContext& context) const {
  if (points.empty()) return {};
  if (empty()) throw InvariantError("distances: the surface has no faces");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!(((points[i] - impl_->center) * impl_->to_unit).cwiseAbs().maxCoeff() <= farthest))
      throw InvariantError("distances: point " + std::to_string(i) +
                           " is not finite or immensely far from the surface");
  const std::vector<Index> order = visiting_order(points, context);
  std::vector<ClosestPoint> results(points.size());
  constexpr std::size_t block_size = 1024;
  parallel_blocks(
      points.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::size_t hint = 0;
        Vec3 best;
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3& query = points[order[i]];
          hint = impl_->nearest(query, hint, best);
          results[order[i]] = impl_->result(query, hint, best);
        }
      },
      block_size);
  return results;
}

}  // namespace gpsrecon
