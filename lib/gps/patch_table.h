#pragma once

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/patch_basis.h>
#include <gpsrecon/gps/refinement_levels.h>
#include <array>
#include <cmath>
#include <optional>

// Internal to lib/gps: exact evaluation of linear subdivision surfaces of either scheme, for values of any kind.

namespace gpsrecon {

/// A value with its derivatives by the two parameters.
template <class T>
struct Jet {
  T value, u, v, uu, uv, vv;
};

/// The faces around a vertex that is not regular, as one of them sees them.
struct Fan {
  Index faces = 0;
  bool boundary = false;
  bool sharp = false;  ///< a corner that is kept
  Index at = 0;        ///< number of the face at hand, counter-clockwise, from the boundary if there is one
  double beta = 0;     ///< Loop's, in the interior
};

/// Connectivity of a surface, prepared for evaluation anywhere. The control mesh is refined once (twice if there are
/// polygons other than quadrilaterals), so that each face has at most one vertex that is not regular, its first: a
/// leaf. On a leaf without one the surface is one polynomial in 12 or 16 points, some of them reflected at the
/// boundary. On the others (s, t) lies on a regular face of some deeper refinement of the points around, of which all
/// but those around the irregular vertex follow from a lattice; these steps are done when evaluating.
class PatchTable {
 public:
  /// Throws InvariantError as triangle_connectivity.
  PatchTable(const FaceList& faces, std::size_t vertex_count, const SurfaceRules& rules,
             const RunContext& context = {});

  std::size_t control_count() const { return control_count_; }
  std::size_t patch_count() const { return patch_count_; }
  bool triangular() const { return scheme_ == Scheme::loop; }
  Index first_patch(std::size_t face) const {
    return first_patch_.empty() ? static_cast<Index>(face) : first_patch_[face];
  }

  /// Parameters on a leaf, with ∂(s, t)/∂(u, v).
  struct LeafPoint {
    Index leaf;
    double s, t;
    double s_u, s_v, t_u, t_v;
  };
  LeafPoint locate(const SurfaceParameter& at) const;

  /// True if the point is the vertex of a leaf where derivatives by parameters do not exist.
  bool extraordinary(const LeafPoint& at) const {
    return kinds_[leaves_[at.leaf].kind].faces > 0 && std::max(at.s, at.t) <= closest;
  }
  /// The vertex at (0, 0) of a leaf that is not regular, numbered like the vertices of the base mesh.
  Index vertex_of(Index leaf) const { return indices_[indices_[leaves_[leaf].begin]]; }
  /// The leaves around a vertex of the base mesh that is not regular; none around others.
  std::span<const Index> leaves_around(Index vertex) const {
    return {fan_leaves_.data() + fan_offsets_[vertex], fan_leaves_.data() + fan_offsets_[vertex + 1]};
  }
  std::size_t base_count() const { return base_count_; }
  /// Weights of limit positions and tangents at the vertices of the base mesh.
  const LimitTable& base_limit() const { return base_limit_; }

  /// Values at the vertices of the base mesh: the control mesh, or its first refinement.
  template <class T>
  std::vector<T> to_base(std::span<const T> control, const RunContext& context) const {
    return to_base_ ? refine_values<T>(*to_base_, control, context) : std::vector<T>(control.begin(), control.end());
  }
  /// Values at the points of the leaves, from those of the base mesh.
  template <class T>
  std::vector<T> to_points(std::span<const T> base, const RunContext& context) const {
    std::vector<T> points = refine_values<T>(to_points_, base, context, ghosts_.size());
    for (const Ghost& ghost : ghosts_)
      points.push_back(points[ghost.plus[0]] + points[ghost.plus[1]] - points[ghost.minus]);
    return points;
  }

  /// Room for the points around an irregular vertex, to be used by one thread at a time.
  template <class T>
  struct Workspace {
    explicit Workspace(const PatchTable& table) : ring(table.largest_ring_), next(table.largest_ring_) {}
    std::vector<T> ring, next;
    std::array<T, 25> window, fine;
  };

  /// The surface at parameters of a leaf and its derivatives by (s, t) up to `Order`; the rest is left as it is.
  /// O(1) on regular leaves, else O(n d) for n faces around the vertex at a parameter distance of 2^-d.
  template <int Order, class T>
  void evaluate(std::span<const T> points, const LeafPoint& at, Workspace<T>& work, Jet<T>& jet) const;

  /// The same by patch parameters.
  template <class T>
  Jet<T> jet(std::span<const T> points, const SurfaceParameter& at, Workspace<T>& work) const;
  template <class T>
  T value(std::span<const T> points, const SurfaceParameter& at, Workspace<T>& work) const {
    Jet<T> jet;
    evaluate<0>(points, locate(at), work, jet);
    return jet.value;
  }

  /// Distance in leaf parameters below which a point counts as the irregular vertex itself.
  static constexpr double closest = 0x1p-50;
  /// Where derivatives are taken instead of at an irregular vertex, in s and t.
  static constexpr double leaf_offset = 2 * SurfaceEvaluator::extraordinary_offset;

 private:
  struct Leaf {
    std::uint32_t
        begin;           ///< first of its indices; if it is not regular, of where its ring begins, and its outer points
    std::uint32_t kind;  ///< 0 = regular
  };
  /// A point beyond the boundary.
  struct Ghost {
    std::array<Index, 2> plus;
    Index minus;
  };
  class Builder;

  template <class T>
  void step_loop(const Fan& fan, Workspace<T>& work, bool last) const;
  template <class T>
  void step_quads(const Fan& fan, Workspace<T>& work, bool last) const;
  template <int Order, class T>
  void evaluate_irregular(std::span<const T> points, const LeafPoint& at, Workspace<T>& work, Jet<T>& jet) const;
  template <int Order, class T, std::size_t Count>
  static void combine(const BasisJet<Count>& basis, const std::array<const T*, Count>& p, double scale, Jet<T>& jet);

  Scheme scheme_ = Scheme::loop;
  std::size_t control_count_ = 0, base_count_ = 0, patch_count_ = 0;
  std::vector<Index> first_patch_;    ///< empty: one per face
  std::vector<Index> base_of_patch_;  ///< empty: the same
  std::vector<bool> split_patch_;     ///< per patch: four faces of the base mesh from base_of_patch_ on
  std::optional<RefinementStep<StencilTable, StencilTable>> to_base_;
  RefinementStep<StencilTable, StencilTable> to_points_;
  LimitTable base_limit_;
  std::vector<Ghost> ghosts_;
  std::vector<Leaf> leaves_;
  std::vector<Index> indices_;
  std::vector<Fan> kinds_{Fan{}};
  std::vector<Index> fan_offsets_, fan_leaves_;
  std::size_t largest_ring_ = 0;
};

// ---------------------------------------------------------------------------------------------------------------------

namespace detail {

/// Index of the lattice point (x, y) in a window of the points with -1 <= x, y <= 3.
constexpr std::size_t at(int x, int y) {
  return static_cast<std::size_t>(5 * (y + 1) + x + 1);
}

/// The outer points of an irregular leaf, in the order of its indices.
inline constexpr std::array<LatticePoint, 5> triangle_outer{{{2, -1}, {2, 0}, {1, 1}, {0, 2}, {-1, 2}}};
inline constexpr std::array<LatticePoint, 7> quad_outer{{{2, -1}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {-1, 2}}};

inline bool at_bottom(const Fan& fan) {
  return fan.boundary && fan.at == 0;
}
inline bool at_left(const Fan& fan) {
  return fan.boundary && fan.at + 1 == fan.faces;
}

/// Where r_i, i >= -1, lies in a ring v, r_0, r_1, ... of triangles.
inline std::size_t spoke(const Fan& fan, Index i) {
  return 1 + (fan.boundary ? i : (i + fan.faces) % fan.faces);
}
/// Where e_i lies in a ring v, e_0, f_0, e_1, f_1, ... of quadrilaterals; f_i is the next.
inline std::size_t quad_spoke(const Fan& fan, Index i) {
  return 1 + 2 * (fan.boundary ? i : (i + fan.faces) % fan.faces);
}
inline std::size_t ring_size(Scheme scheme, const Fan& fan) {
  const std::size_t open = fan.boundary ? 1 : 0;
  return scheme == Scheme::loop ? 1 + fan.faces + open : 1 + 2 * fan.faces + open;
}

/// The points of the ring that lie in the window, and those reflected at the boundary.
template <class T>
void fill_loop_window(const Fan& fan, const std::vector<T>& ring, std::array<T, 25>& w) {
  w[at(0, 0)] = ring[0];
  w[at(1, 0)] = ring[spoke(fan, fan.at)];
  w[at(0, 1)] = ring[spoke(fan, fan.at + 1)];
  if (!at_bottom(fan)) w[at(1, -1)] = ring[spoke(fan, fan.at + fan.faces - 1 - (fan.boundary ? fan.faces : 0))];
  if (!at_left(fan)) w[at(-1, 1)] = ring[spoke(fan, fan.at + 2)];
}
template <class T>
void reflect_loop_window(const Fan& fan, std::array<T, 25>& w, int size) {
  if (at_bottom(fan))
    for (int x = 1; x <= size; ++x) w[at(x, -1)] = w[at(x - 1, 0)] + w[at(x, 0)] - w[at(x - 1, 1)];
  if (at_left(fan))
    for (int y = 1; y <= size; ++y) w[at(-1, y)] = w[at(0, y - 1)] + w[at(0, y)] - w[at(1, y - 1)];
}

template <class T>
void fill_quad_window(const Fan& fan, const std::vector<T>& ring, std::array<T, 25>& w) {
  w[at(0, 0)] = ring[0];
  w[at(1, 0)] = ring[quad_spoke(fan, fan.at)];
  w[at(1, 1)] = ring[quad_spoke(fan, fan.at) + 1];
  w[at(0, 1)] = ring[quad_spoke(fan, fan.at + 1)];
  if (!at_bottom(fan)) {
    const std::size_t before = quad_spoke(fan, fan.at + fan.faces - 1 - (fan.boundary ? fan.faces : 0));
    w[at(0, -1)] = ring[before];
    w[at(1, -1)] = ring[before + 1];
  }
  if (!at_left(fan)) {
    w[at(-1, 0)] = ring[quad_spoke(fan, fan.at + 2)];
    w[at(-1, 1)] = ring[quad_spoke(fan, fan.at + 1) + 1];
  }
}
template <class T>
void reflect_quad_window(const Fan& fan, std::array<T, 25>& w, int size) {
  if (at_bottom(fan))
    for (int x = 0; x <= size; ++x) w[at(x, -1)] = 2.0 * w[at(x, 0)] - w[at(x, 1)];
  if (at_left(fan))
    for (int y = 0; y <= size; ++y) w[at(-1, y)] = 2.0 * w[at(0, y)] - w[at(1, y)];
}

/// Limit position of the vertex of a ring.
template <class T>
T ring_limit(Scheme scheme, const Fan& fan, const std::vector<T>& ring) {
  if (fan.sharp) return ring[0];
  const bool loop = scheme == Scheme::loop;
  if (fan.boundary) return 2.0 / 3 * ring[0] + 1.0 / 6 * (ring[1] + ring[loop ? 1 + fan.faces : 1 + 2 * fan.faces]);
  const double n = fan.faces;
  T near = zero<T>(), far = zero<T>();
  for (Index i = 0; i < fan.faces; ++i) {
    near += ring[loop ? 1 + i : 1 + 2 * i];
    if (!loop) far += ring[2 + 2 * i];
  }
  if (loop) {
    const double omega = 1 / (n + 3 / (8 * fan.beta));
    return (1 - n * omega) * ring[0] + omega * near;
  }
  return n / (n + 5) * ring[0] + 4 / (n * (n + 5)) * near + 1 / (n * (n + 5)) * far;
}

/// The ring after a step of Loop's scheme.
template <class T>
void refine_loop_ring(const Fan& fan, const std::vector<T>& ring, std::vector<T>& next) {
  const Index n = fan.faces, spokes = fan.boundary ? n + 1 : n;
  const T& v = ring[0];
  for (Index i = 0; i < spokes; ++i) {
    if (fan.boundary && (i == 0 || i == n))
      next[1 + i] = 0.5 * (v + ring[1 + i]);
    else
      next[1 + i] = 0.375 * (v + ring[1 + i]) + 0.125 * (ring[spoke(fan, i + 1)] + ring[1 + (i == 0 ? n - 1 : i - 1)]);
  }
  if (fan.sharp) {
    next[0] = v;
  } else if (fan.boundary) {
    next[0] = 0.75 * v + 0.125 * (ring[1] + ring[1 + n]);
  } else {
    T sum = zero<T>();
    for (Index i = 0; i < n; ++i) sum += ring[1 + i];
    next[0] = (1 - n * fan.beta) * v + fan.beta * sum;
  }
}

/// The ring after a step of Catmull and Clark's scheme.
template <class T>
void refine_quad_ring(const Fan& fan, const std::vector<T>& ring, std::vector<T>& next) {
  const Index n = fan.faces;
  const T& v = ring[0];
  T faces = zero<T>(), edges = zero<T>();
  for (Index i = 0; i < n; ++i) {
    const std::size_t e = 1 + 2 * i;
    next[e + 1] = 0.25 * (v + ring[e] + ring[e + 1] + ring[quad_spoke(fan, i + 1)]);
    faces += next[e + 1];
    edges += ring[e];
  }
  for (Index i = 0; i <= n; ++i) {
    if (i == n && !fan.boundary) break;
    const std::size_t e = 1 + 2 * i;
    if (fan.boundary && (i == 0 || i == n))
      next[e] = 0.5 * (v + ring[e]);
    else
      next[e] = 0.25 * (v + ring[e] + next[e + 1] + next[i == 0 ? 2 * n : e - 1]);
  }
  if (fan.sharp) {
    next[0] = v;
  } else if (fan.boundary) {
    next[0] = 0.75 * v + 0.125 * (ring[1] + ring[1 + 2 * n]);
  } else {
    const double inverse = 1.0 / n;
    next[0] = (1 - 2 * inverse) * v + inverse * (inverse * faces + inverse * edges);
  }
}

}  // namespace detail

template <class T>
void PatchTable::step_loop(const Fan& fan, Workspace<T>& work, bool last) const {
  using detail::at;
  const std::array<T, 25>& w = work.window;
  std::array<T, 25>& f = work.fine;
  const auto edge = [&w](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return 0.375 * (w[a] + w[b]) + 0.125 * (w[c] + w[d]);
  };
  const auto vertex = [&w](int x, int y) {
    return 0.625 * w[at(x, y)] + 0.0625 * (w[at(x + 1, y)] + w[at(x, y + 1)] + w[at(x - 1, y + 1)] + w[at(x - 1, y)] +
                                           w[at(x, y - 1)] + w[at(x + 1, y - 1)]);
  };
  // From the ring: everything that depends on what lies around the irregular vertex.
  detail::refine_loop_ring(fan, work.ring, work.next);
  work.ring.swap(work.next);
  detail::fill_loop_window(fan, work.ring, f);
  // The neighbours (1, 0) and (0, 1) of the vertex are regular; where the window does not reach, it is not needed.
  f[at(2, 0)] = vertex(1, 0);
  f[at(0, 2)] = vertex(0, 1);
  f[at(1, 1)] = edge(at(1, 0), at(0, 1), at(0, 0), at(1, 1));
  f[at(2, -1)] = edge(at(1, 0), at(1, -1), at(0, 0), at(2, -1));
  f[at(-1, 2)] = edge(at(0, 1), at(-1, 1), at(0, 0), at(-1, 2));
  if (last) {
    f[at(3, 0)] = edge(at(1, 0), at(2, 0), at(1, 1), at(2, -1));
    f[at(0, 3)] = edge(at(0, 1), at(0, 2), at(1, 1), at(-1, 2));
    f[at(2, 1)] = edge(at(1, 0), at(1, 1), at(2, 0), at(0, 1));
    f[at(1, 2)] = edge(at(0, 1), at(1, 1), at(0, 2), at(1, 0));
    f[at(3, -1)] = edge(at(1, 0), at(2, -1), at(1, -1), at(2, 0));
    f[at(-1, 3)] = edge(at(0, 1), at(-1, 2), at(-1, 1), at(0, 2));
  }
  detail::reflect_loop_window(fan, f, last ? 3 : 2);
  work.window.swap(work.fine);
}

template <class T>
void PatchTable::step_quads(const Fan& fan, Workspace<T>& work, bool last) const {
  using detail::at;
  const std::array<T, 25>& w = work.window;
  std::array<T, 25>& f = work.fine;
  const auto face = [&w](int x, int y) {
    return 0.25 * (w[at(x, y)] + w[at(x + 1, y)] + w[at(x, y + 1)] + w[at(x + 1, y + 1)]);
  };
  const auto edge_x = [&w](int x, int y) {  // from (x, y) to (x + 1, y)
    return 0.375 * (w[at(x, y)] + w[at(x + 1, y)]) +
           0.0625 * (w[at(x, y + 1)] + w[at(x + 1, y + 1)] + w[at(x, y - 1)] + w[at(x + 1, y - 1)]);
  };
  const auto edge_y = [&w](int x, int y) {
    return 0.375 * (w[at(x, y)] + w[at(x, y + 1)]) +
           0.0625 * (w[at(x + 1, y)] + w[at(x + 1, y + 1)] + w[at(x - 1, y)] + w[at(x - 1, y + 1)]);
  };
  const auto vertex = [&w](int x, int y) {
    return 0.5625 * w[at(x, y)] + 0.09375 * (w[at(x + 1, y)] + w[at(x - 1, y)] + w[at(x, y + 1)] + w[at(x, y - 1)]) +
           0.015625 * (w[at(x + 1, y + 1)] + w[at(x - 1, y + 1)] + w[at(x + 1, y - 1)] + w[at(x - 1, y - 1)]);
  };
  detail::refine_quad_ring(fan, work.ring, work.next);
  work.ring.swap(work.next);
  detail::fill_quad_window(fan, work.ring, f);
  f[at(2, 0)] = vertex(1, 0);
  f[at(0, 2)] = vertex(0, 1);
  f[at(2, 2)] = vertex(1, 1);
  f[at(2, 1)] = edge_y(1, 0);
  f[at(1, 2)] = edge_x(0, 1);
  f[at(2, -1)] = edge_y(1, -1);
  f[at(-1, 2)] = edge_x(-1, 1);
  if (last) {
    f[at(3, -1)] = face(1, -1);
    f[at(3, 0)] = edge_x(1, 0);
    f[at(3, 1)] = face(1, 0);
    f[at(3, 2)] = edge_x(1, 1);
    f[at(3, 3)] = face(1, 1);
    f[at(2, 3)] = edge_y(1, 1);
    f[at(1, 3)] = face(0, 1);
    f[at(0, 3)] = edge_y(0, 1);
    f[at(-1, 3)] = face(-1, 1);
  }
  detail::reflect_quad_window(fan, f, last ? 3 : 2);
  work.window.swap(work.fine);
}

template <int Order, class T, std::size_t Count>
void PatchTable::combine(const BasisJet<Count>& basis, const std::array<const T*, Count>& p, double scale,
                         Jet<T>& jet) {
  const std::array<T*, 6> parts{&jet.value, &jet.u, &jet.v, &jet.uu, &jet.uv, &jet.vv};
  constexpr std::size_t rows = Order == 0 ? 1 : Order == 1 ? 3 : 6;
  for (std::size_t k = 0; k < rows; ++k) {
    const double factor = k == 0 ? 1 : k < 3 ? scale : scale * scale;
    T sum = (factor * basis[k][0]) * *p[0];
    for (std::size_t i = 1; i < Count; ++i) sum += (factor * basis[k][i]) * *p[i];
    *parts[k] = sum;
  }
}

template <int Order, class T>
void PatchTable::evaluate_irregular(std::span<const T> points, const LeafPoint& place, Workspace<T>& work,
                                    Jet<T>& jet) const {
  using detail::at;
  const Leaf& leaf = leaves_[place.leaf];
  const Fan& fan = kinds_[leaf.kind];
  const bool loop = scheme_ == Scheme::loop;
  const std::size_t ring = detail::ring_size(scheme_, fan);
  const Index* around = indices_.data() + indices_[leaf.begin];
  const Index* outer = indices_.data() + leaf.begin + 1;
  work.ring.resize(ring);
  work.next.resize(ring);
  for (std::size_t i = 0; i < ring; ++i) work.ring[i] = points[around[i]];
  // Relative to the limit point, which derivatives do not see and position converges to, digits last at any depth.
  T limit = detail::ring_limit(scheme_, fan, work.ring);
  if (extraordinary(place)) {
    jet.value = limit;
    if constexpr (Order > 0) {
      LeafPoint off = place;
      off.s = off.t = leaf_offset;
      Jet<T> near;
      evaluate_irregular<Order>(points, off, work, near);
      jet = near;
      jet.value = limit;
    }
    return;
  }
  for (T& p : work.ring) p = p - limit;
  const auto load_outer = [&](const auto& places) {
    for (std::size_t i = 0; i < places.size(); ++i)
      if (outer[i] != no_index) work.window[at(places[i].x, places[i].y)] = points[outer[i]] - limit;
  };
  if (loop) {
    load_outer(detail::triangle_outer);
    detail::fill_loop_window(fan, work.ring, work.window);
    detail::reflect_loop_window(fan, work.window, 2);
  } else {
    load_outer(detail::quad_outer);
    detail::fill_quad_window(fan, work.ring, work.window);
    detail::reflect_quad_window(fan, work.window, 2);
  }
  double s = 2 * place.s, t = 2 * place.t, scale = 2;
  while (loop ? s + t < 1 : s < 1 && t < 1) {
    loop ? step_loop(fan, work, false) : step_quads(fan, work, false);
    s *= 2, t *= 2, scale *= 2;
  }
  loop ? step_loop(fan, work, true) : step_quads(fan, work, true);
  if (loop) {
    // The face that continues the edge to (1, 0), that to (0, 1), or the one between, which is upside down.
    const bool right = s >= 1, top = !right && t >= 1, between = !right && !top;
    std::array<const T*, 12> p;
    for (std::size_t i = 0; i < 12; ++i) {
      const auto [x, y] = triangle_patch[i];
      p[i] = &work.window[between ? at(1 - x, 1 - y) : right ? at(1 + x, y) : at(x, 1 + y)];
    }
    const BasisJet<12> basis = between ? box_spline_basis(1 - s, 1 - t, Order)
                               : right ? box_spline_basis(s - 1, t, Order)
                                       : box_spline_basis(s, t - 1, Order);
    combine<Order>(basis, p, between ? -scale : scale, jet);
  } else {
    const int i = s >= 1 ? 1 : 0, j = t >= 1 ? 1 : 0;
    std::array<const T*, 16> p;
    for (int y = -1; y <= 2; ++y)
      for (int x = -1; x <= 2; ++x) p[static_cast<std::size_t>(4 * (y + 1) + x + 1)] = &work.window[at(i + x, j + y)];
    combine<Order>(bicubic_basis(s - i, t - j, Order), p, scale, jet);
  }
  jet.value = limit + jet.value;
}

template <int Order, class T>
void PatchTable::evaluate(std::span<const T> points, const LeafPoint& place, Workspace<T>& work, Jet<T>& jet) const {
  const Leaf& leaf = leaves_[place.leaf];
  if (leaf.kind != 0) return evaluate_irregular<Order>(points, place, work, jet);
  const Index* index = indices_.data() + leaf.begin;
  if (scheme_ == Scheme::loop) {
    std::array<const T*, 12> p;
    for (std::size_t i = 0; i < 12; ++i) p[i] = &points[index[i]];
    combine<Order>(box_spline_basis(place.s, place.t, Order), p, 1, jet);
  } else {
    std::array<const T*, 16> p;
    for (std::size_t i = 0; i < 16; ++i) p[i] = &points[index[i]];
    combine<Order>(bicubic_basis(place.s, place.t, Order), p, 1, jet);
  }
}

template <class T>
Jet<T> PatchTable::jet(std::span<const T> points, const SurfaceParameter& at, Workspace<T>& work) const {
  const LeafPoint place = locate(at);
  Jet<T> leaf, jet;
  evaluate<2>(points, place, work, leaf);
  const auto [l, s, t, su, sv, tu, tv] = place;
  jet.value = leaf.value;
  jet.u = su * leaf.u + tu * leaf.v;
  jet.v = sv * leaf.u + tv * leaf.v;
  jet.uu = su * su * leaf.uu + 2 * su * tu * leaf.uv + tu * tu * leaf.vv;
  jet.uv = su * sv * leaf.uu + (su * tv + sv * tu) * leaf.uv + tu * tv * leaf.vv;
  jet.vv = sv * sv * leaf.uu + 2 * sv * tv * leaf.uv + tv * tv * leaf.vv;
  return jet;
}

}  // namespace gpsrecon
