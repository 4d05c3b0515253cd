#include <gpsrecon/triangulate/growing_surface.h>
#include <Eigen/Geometry>
#include <algorithm>

namespace gpsrecon::internal {
namespace {

/// Index of v in t; t contains v.
int corner(const GrowingSurface::Triangle& t, Index v) {
  return t[0] == v ? 0 : t[1] == v ? 1 : 2;
}
Index after(const GrowingSurface::Triangle& t, Index v) {
  return t[static_cast<std::size_t>(corner(t, v) + 1) % 3];
}
Index before(const GrowingSurface::Triangle& t, Index v) {
  return t[static_cast<std::size_t>(corner(t, v) + 2) % 3];
}

}  // namespace

GrowingSurface::GrowingSurface(const std::vector<Vec3>& positions)
    : positions_(&positions), around_(positions.size()) {}

Vec3 GrowingSurface::unit_normal(Index a, Index b, Index c) const {
  const Vec3 ab = position(b) - position(a), ac = position(c) - position(a);
  const Vec3 n = ab.cross(ac);
  const double length = n.norm();
  // Below this height over the longest side the direction is that of rounding errors.
  constexpr double flat = 1e-9;
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  return length > flat * longest ? Vec3(n / length) : Vec3::Zero();
}

Index GrowingSurface::add(const Triangle& t) {
  const auto number = static_cast<Index>(triangles_.size());
  triangles_.push_back(t);
  normals_.push_back(unit_normal(t[0], t[1], t[2]));
  for (const Index v : t) around_[v].push_back(number);
  return number;
}

void GrowingSurface::remove(Index number) {
  for (const Index v : triangles_[number]) std::erase(around_[v], number);
  if (number + 1 == triangles_.size()) {
    triangles_.pop_back();
    normals_.pop_back();
  } else {
    triangles_[number] = {no_index, no_index, no_index};
  }
}

Index GrowingSurface::triangle_at(Index from, Index to) const {
  for (const Index t : around_[from])
    if (after(triangles_[t], from) == to) return t;
  return no_index;
}

std::size_t GrowingSurface::front_edges() const {
  std::size_t count = 0;
  for (const Triangle& t : triangles_)
    for (std::size_t k = 0; t[0] != no_index && k < 3; ++k) count += on_front(t[k], t[(k + 1) % 3]) ? 1 : 0;
  return count;
}

Index GrowingSurface::third_corner(Index t, Index a, Index b) const {
  const Triangle& corners = triangles_[t];
  for (const Index v : corners)
    if (v != a && v != b) return v;
  return no_index;
}

void GrowingSurface::fans(Index v, std::vector<Fan>& found) const {
  found.clear();
  std::size_t visited = 0;
  for (const Index t : around_[v]) {
    const Index first = after(triangles_[t], v);
    if (has(first, v)) continue;  // not the first triangle of its fan
    Fan fan{first, first, 0};
    for (Index next = t; next != no_index; next = triangle_at(v, fan.last)) {
      fan.last = before(triangles_[next], v);
      ++fan.triangles;
    }
    visited += fan.triangles;
    found.push_back(fan);
  }
  // What no open fan visited lies in closed ones.
  if (visited == around_[v].size()) return;
  std::vector<Index> open = around_[v];
  for (const Fan& fan : found)
    for (Index at = fan.first; at != fan.last;) {
      const Index t = triangle_at(v, at);
      std::erase(open, t);
      at = before(triangles_[t], v);
    }
  while (!open.empty()) {
    const Index start = after(triangles_[open.front()], v);
    Fan fan{start, start, 0};
    Index at = start;
    do {
      const Index t = triangle_at(v, at);
      std::erase(open, t);
      at = before(triangles_[t], v);
      ++fan.triangles;
    } while (at != start);
    found.push_back(fan);
  }
}

bool GrowingSurface::can_grow(Index v) const {
  if (around_[v].empty()) return true;
  for (const Index t : around_[v])
    if (!has(after(triangles_[t], v), v)) return true;
  return false;
}

FaceList GrowingSurface::faces() const {
  FaceList faces;
  faces.reserve(triangles_.size(), 3 * triangles_.size());
  for (const Triangle& t : triangles_)
    if (t[0] != no_index) faces.add(t[0], t[1], t[2]);
  return faces;
}

}  // namespace gpsrecon::internal
