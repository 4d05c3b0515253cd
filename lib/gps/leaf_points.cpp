#include <gpsrecon/gps/leaf_points.h>
#include <array>

namespace gpsrecon::internal {
namespace {

constexpr std::array<LatticePoint, 6> directions{{{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}}};

/// The points with -1 <= x, y <= 2 around a face.
class Window {
 public:
  Window() { points_.fill(no_index); }
  Index& operator()(int x, int y) {
    const int at = 4 * (y + 1) + x + 1;
    return points_[static_cast<std::size_t>(at)];
  }

 private:
  std::array<Index, 16> points_;
};

}  // namespace

bool LeafPoints::regular(Index v) const {
  const Index n = mesh_.face_count[v];
  if (!mesh_.on_boundary(v)) return n == (triangles_ ? 6 : 4);
  return n == (triangles_ ? 3 : 2) || (!triangles_ && n == 1 && sharp_corners_);
}

Index LeafPoints::reflected(Index a, Index b, Index inner) {
  ghosts_.push_back({{a, b}, inner});
  return static_cast<Index>(mesh_.vertex_count + ghosts_.size() - 1);
}

// Triangles -----------------------------------------------------------------------------------------------------------

/// The six neighbours of the regular vertex that h leaves, by direction, if h has direction `first`.
std::array<Index, 6> LeafPoints::neighbors(Index h, int first) {
  std::array<Index, 6> around;
  around.fill(no_index);
  const auto slot = [](int d) { return static_cast<std::size_t>((d % 6 + 6) % 6); };
  int low = first, high = first;
  around[slot(first)] = target(h);
  for (Index g = h; high < first + 5;) {
    const Index arriving = previous(g);
    around[slot(++high)] = source(arriving);
    g = opposite(arriving);
    if (g == no_index) break;
  }
  for (Index g = opposite(h); high - low < 5 && g != no_index; g = opposite(next(g)))
    around[slot(--low)] = target(next(g));
  if (high - low < 5) {
    // The boundary passes along `low` and `high`; the two neighbours between are reflected.
    const Index v = source(h);
    around[slot(low - 1)] = reflected(v, around[slot(low)], around[slot(low + 1)]);
    around[slot(high + 1)] = reflected(v, around[slot(high)], around[slot(high - 1)]);
  }
  return around;
}

void LeafPoints::add_triangle_patch(Index h, std::vector<Index>& to) {
  Window window;
  constexpr std::array<LatticePoint, 3> corners{{{0, 0}, {1, 0}, {0, 1}}};
  for (int i = 0; i < 3; ++i, h = next(h)) {
    const auto [x, y] = corners[static_cast<std::size_t>(i)];
    window(x, y) = source(h);
    const std::array<Index, 6> around = neighbors(h, 2 * i);
    for (std::size_t d = 0; d < 6; ++d) {
      Index& point = window(x + directions[d].x, y + directions[d].y);
      if (point == no_index) point = around[d];
    }
  }
  for (const auto [x, y] : triangle_patch) to.push_back(window(x, y));
}

// Quadrilaterals ------------------------------------------------------------------------------------------------------

void LeafPoints::add_quad_patch(Index h, std::vector<Index>& to) {
  Window w;
  // What the two edges at (1, 1) are next to is there, as they are interior; what is beyond the others need not be.
  const Index below = opposite(h), right = opposite(next(h)), above = opposite(next(next(h))),
              left = opposite(previous(h));
  w(0, 0) = source(h);
  w(1, 0) = target(h);
  w(1, 1) = target(next(h));
  w(0, 1) = source(previous(h));
  w(2, 0) = target(next(right));
  w(2, 1) = source(previous(right));
  w(2, 2) = target(next(opposite(previous(right))));
  w(1, 2) = target(next(above));
  w(0, 2) = source(previous(above));
  if (below != no_index) {
    w(0, -1) = target(next(below));
    w(1, -1) = source(previous(below));
    w(2, -1) = target(next(opposite(previous(below))));
  }
  if (left != no_index) {
    w(-1, 1) = target(next(left));
    w(-1, 0) = source(previous(left));
    w(-1, 2) = source(previous(opposite(next(left))));
  }
  if (below != no_index && left != no_index) w(-1, -1) = source(previous(opposite(next(below))));
  const auto reflect = [&](int x, int y, int dx, int dy) {
    const Index mirror = w(x + dx, y + dy);
    w(x, y) = reflected(mirror, mirror, w(x + 2 * dx, y + 2 * dy));
  };
  if (below == no_index)
    for (int x = left == no_index ? 0 : -1; x <= 2; ++x) reflect(x, -1, 0, 1);
  if (left == no_index)
    for (int y = -1; y <= 2; ++y) reflect(-1, y, 1, 0);
  for (int y = -1; y <= 2; ++y)
    for (int x = -1; x <= 2; ++x) to.push_back(w(x, y));
}

// Around irregular vertices -------------------------------------------------------------------------------------------

void LeafPoints::add_own(Index h, std::vector<Index>& to) const {
  to.push_back(source(h));
  if (triangles_) {
    // (1, 1), and around (1, 0) and (0, 1) on both sides of it, as far as there are faces.
    const Index across = opposite(next(h));
    to.push_back(source(previous(across)));
    const Index right = opposite(next(across)), top = opposite(previous(across));
    to.push_back(target(next(right)));
    to.push_back(source(previous(top)));
    if (const Index g = opposite(next(right)); g != no_index) to.push_back(target(next(g)));
    if (const Index g = opposite(previous(top)); g != no_index) to.push_back(source(previous(g)));
    return;
  }
  const Index right = opposite(next(h)), above = opposite(next(next(h)));
  to.push_back(target(next(right)));
  to.push_back(source(previous(right)));
  to.push_back(target(next(opposite(previous(right)))));
  to.push_back(target(next(above)));
  to.push_back(source(previous(above)));
  if (const Index g = opposite(h); g != no_index) to.push_back(target(next(opposite(previous(g)))));
  if (const Index g = opposite(previous(h)); g != no_index) to.push_back(source(previous(opposite(next(g)))));
}

}  // namespace gpsrecon::internal
