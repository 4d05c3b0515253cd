#include <gpsrecon/gps/patch_table.h>

#include <gpsrecon/core/error.h>
#include <map>
#include <tuple>

namespace gpsrecon {

/// Walks around the faces of the refined mesh and writes down the points of each leaf.
class PatchTable::Builder {
 public:
  /// `corners` and `opposite` per half-edge of the refined mesh, whose faces all have three or all have four.
  Builder(PatchTable& table, const std::vector<Index>& corners, const std::vector<Index>& opposite,
          const SurfaceRules& rules)
      : table_(table),
        corners_(corners),
        opposite_(opposite),
        rules_(rules),
        start_(table.to_points_.new_vertices(), no_index),
        count_(table.to_points_.new_vertices(), 0),
        ring_(table.base_count_, no_index),
        at_(corners.size() / size(), 0) {
    for (Index h = 0; h < corners.size(); ++h) {
      const Index v = corners[h];
      if (start_[v] == no_index || opposite[h] == no_index) start_[v] = h;
      ++count_[v];
    }
  }

  void build() {
    const std::size_t faces = corners_.size() / size();
    table_.leaves_.reserve(faces);
    std::vector<std::vector<Index>> around(table_.base_count_);
    for (Index f = 0; f < faces; ++f) {
      const Index h = size() * f, v = source(h);
      if (regular(v)) {
        table_.leaves_.push_back({static_cast<std::uint32_t>(table_.indices_.size()), 0});
        loop() ? add_regular_triangle(h) : add_regular_quad(h);
        continue;
      }
      if (v >= table_.base_count_) throw InvariantError("evaluation: an inner vertex of a face is not regular");
      if (around[v].empty()) add_ring(v);
      around[v].push_back(f);
      const Fan fan = fan_at(h);
      table_.leaves_.push_back({static_cast<std::uint32_t>(table_.indices_.size()), kind_of(fan)});
      table_.largest_ring_ = std::max(table_.largest_ring_, detail::ring_size(rules_.scheme, fan));
      add(ring_[v]);
      loop() ? add_outer_triangle(fan, h) : add_outer_quad(fan, h);
    }
    table_.fan_offsets_.assign(1, 0);
    for (const std::vector<Index>& leaves : around) {
      table_.fan_leaves_.insert(table_.fan_leaves_.end(), leaves.begin(), leaves.end());
      table_.fan_offsets_.push_back(static_cast<Index>(table_.fan_leaves_.size()));
    }
  }

 private:
  bool loop() const { return rules_.scheme == Scheme::loop; }
  Index size() const { return loop() ? 3 : 4; }
  Index next(Index h) const { return h % size() + 1 == size() ? h + 1 - size() : h + 1; }
  Index previous(Index h) const { return h % size() == 0 ? h + size() - 1 : h - 1; }
  Index opposite(Index h) const { return opposite_[h]; }
  Index source(Index h) const { return corners_[h]; }
  Index target(Index h) const { return corners_[next(h)]; }
  bool on_boundary(Index v) const { return opposite(start_[v]) == no_index; }

  bool regular(Index v) const {
    const Index n = count_[v];
    if (!on_boundary(v)) return n == (loop() ? 6 : 4);
    return n == (loop() ? 3 : 2) || (!loop() && n == 1 && rules_.corners == CornerRule::sharp);
  }

  Fan fan_at(Index h) const {
    const Index v = source(h);
    Fan fan{.faces = count_[v], .boundary = on_boundary(v), .at = at_[h / size()]};
    fan.sharp = fan.boundary && fan.faces == 1 && rules_.corners == CornerRule::sharp;
    if (!fan.boundary && loop()) fan.beta = loop_beta(rules_.weights, fan.faces);
    return fan;
  }

  std::uint32_t kind_of(const Fan& fan) {
    const auto [at, added] = kinds_.try_emplace({fan.faces, fan.boundary, fan.at}, table_.kinds_.size());
    if (added) table_.kinds_.push_back(fan);
    return static_cast<std::uint32_t>(at->second);
  }

  void add(Index point) { table_.indices_.push_back(point); }

  Index reflected(Index a, Index b, Index inner) {
    table_.ghosts_.push_back({{a, b}, inner});
    return static_cast<Index>(table_.to_points_.new_vertices() + table_.ghosts_.size() - 1);
  }

  /// The vertex and its neighbours, counter-clockwise, once for all leaves around it; and their numbers.
  void add_ring(Index v) {
    ring_[v] = static_cast<Index>(table_.indices_.size());
    add(v);
    Index g = start_[v], number = 0;
    do {
      at_[g / size()] = number++;
      add(target(g));
      if (!loop()) add(target(next(g)));
      const Index arriving = previous(g);
      g = opposite(arriving);
      if (g == no_index) add(source(arriving));
    } while (g != no_index && g != start_[v]);
  }

  // Triangles -------------------------------------------------------------------------------------------------------

  static constexpr std::array<LatticePoint, 6> directions{{{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}}};

  /// The six neighbours of the regular vertex that h leaves, by direction, if h has direction `first`.
  std::array<Index, 6> neighbors(Index h, int first) {
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

  void add_regular_triangle(Index h) {
    std::array<Index, 25> window;
    window.fill(no_index);
    const std::array<LatticePoint, 3> corners{{{0, 0}, {1, 0}, {0, 1}}};
    for (int i = 0; i < 3; ++i, h = next(h)) {
      const auto [x, y] = corners[static_cast<std::size_t>(i)];
      window[detail::at(x, y)] = source(h);
      const std::array<Index, 6> around = neighbors(h, 2 * i);
      for (std::size_t d = 0; d < 6; ++d) {
        Index& point = window[detail::at(x + directions[d].x, y + directions[d].y)];
        if (point == no_index) point = around[d];
      }
    }
    for (const auto [x, y] : triangle_patch) add(window[detail::at(x, y)]);
  }

  void add_outer_triangle(const Fan& fan, Index h) {
    const std::array<Index, 6> first = neighbors(next(h), 2), second = neighbors(next(next(h)), 4);
    add(detail::at_bottom(fan) ? no_index : first[5]);
    add(first[0]);
    add(first[1]);
    add(second[1]);
    add(detail::at_left(fan) ? no_index : second[2]);
  }

  // Quadrilaterals --------------------------------------------------------------------------------------------------

  /// What lies beyond the two edges away from the first vertex, which are interior, and where there is something,
  /// beyond the two at it.
  void outer_quads(Index h, std::array<Index, 25>& w) const {
    using detail::at;
    const Index below = opposite(h), right = opposite(next(h)), above = opposite(next(next(h))),
                left = opposite(previous(h));
    w[at(2, 0)] = target(next(right));
    w[at(2, 1)] = source(previous(right));
    const Index diagonal = opposite(previous(right));
    w[at(2, 2)] = target(next(diagonal));
    w[at(1, 2)] = target(next(above));
    w[at(0, 2)] = source(previous(above));
    if (below != no_index) w[at(2, -1)] = target(next(opposite(previous(below))));
    if (left != no_index) w[at(-1, 2)] = source(previous(opposite(next(left))));
  }

  void add_regular_quad(Index h) {
    using detail::at;
    std::array<Index, 25> w;
    w.fill(no_index);
    w[at(0, 0)] = source(h);
    w[at(1, 0)] = target(h);
    w[at(1, 1)] = target(next(h));
    w[at(0, 1)] = source(previous(h));
    outer_quads(h, w);
    const Index below = opposite(h), left = opposite(previous(h));
    if (below != no_index) {
      w[at(0, -1)] = target(next(below));
      w[at(1, -1)] = source(previous(below));
    }
    if (left != no_index) {
      w[at(-1, 1)] = target(next(left));
      w[at(-1, 0)] = source(previous(left));
    }
    if (below != no_index && left != no_index) w[at(-1, -1)] = source(previous(opposite(next(below))));
    const auto reflect = [&](int x, int y, int dx, int dy) {
      const Index mirror = w[at(x + dx, y + dy)];
      w[at(x, y)] = reflected(mirror, mirror, w[at(x + 2 * dx, y + 2 * dy)]);
    };
    if (below == no_index)
      for (int x = left == no_index ? 0 : -1; x <= 2; ++x) reflect(x, -1, 0, 1);
    if (left == no_index)
      for (int y = -1; y <= 2; ++y) reflect(-1, y, 1, 0);
    for (int y = -1; y <= 2; ++y)
      for (int x = -1; x <= 2; ++x) add(w[at(x, y)]);
  }

  void add_outer_quad(const Fan& fan, Index h) {
    std::array<Index, 25> w;
    w.fill(no_index);
    outer_quads(h, w);
    if (detail::at_bottom(fan)) w[detail::at(2, -1)] = no_index;
    if (detail::at_left(fan)) w[detail::at(-1, 2)] = no_index;
    for (const auto [x, y] : detail::quad_outer) add(w[detail::at(x, y)]);
  }

  PatchTable& table_;
  const std::vector<Index>&corners_, &opposite_;
  const SurfaceRules& rules_;
  std::vector<Index> start_, count_;
  std::vector<Index> ring_;  ///< per vertex of the base mesh: where its ring begins
  std::vector<Index> at_;    ///< per leaf: its number around its vertex
  std::map<std::tuple<Index, bool, Index>, std::size_t> kinds_;
};

PatchTable::PatchTable(const FaceList& faces, std::size_t vertex_count, const SurfaceRules& rules,
                       const RunContext& context)
    : scheme_(rules.scheme), control_count_(vertex_count), base_count_(vertex_count) {
  if (scheme_ == Scheme::loop) {
    const Connectivity topology = triangle_connectivity(faces, vertex_count);
    base_limit_ = limit_table(topology, rules.weights, rules.corners, context);
    to_points_ = tabulate(LoopScheme::step(topology, rules), context);
    const Connectivity fine = refine_triangles(topology, context);
    patch_count_ = faces.size();
    Builder(*this, fine.corners, fine.opposite, rules).build();
  } else {
    Connectivity base = manifold_connectivity(faces, vertex_count, "subdivision");
    if (faces.all_of_size(4)) {
      patch_count_ = faces.size();
    } else {
      // One patch per corner, or the four around the middle of a quadrilateral in one.
      for (std::size_t f = 0; f < faces.size(); ++f) {
        const Index first = faces.offsets[f], n = faces.offsets[f + 1] - first;
        first_patch_.push_back(static_cast<Index>(base_of_patch_.size()));
        for (Index i = 0; i < (n == 4 ? 1 : n); ++i) {
          base_of_patch_.push_back(first + i);
          split_patch_.push_back(n == 4);
        }
      }
      patch_count_ = base_of_patch_.size();
      to_base_ = tabulate(CatmullClarkScheme::step(base, rules), context);
      base = refine_to_quads(base, context);
      base_count_ = base.vertex_count;
    }
    base_limit_ = tabulate(CatmullClarkScheme::limit(base, rules, false), context);
    to_points_ = tabulate(CatmullClarkScheme::step(base, rules), context);
    const Connectivity fine = refine_to_quads(base, context);
    Builder(*this, fine.corners, fine.opposite, rules).build();
  }
}

namespace {

/// A quarter of a quadrilateral, seen from its corner.
PatchTable::LeafPoint quarter(Index face, double u, double v) {
  const Index first = 4 * face;
  if (v < 0.5) {
    if (u < 0.5) return {first, 2 * u, 2 * v, 2, 0, 0, 2};
    return {first + 1, 2 * v, 2 * (1 - u), 0, 2, -2, 0};
  }
  if (u < 0.5) return {first + 3, 2 * (1 - v), 2 * u, 0, -2, 2, 0};
  return {first + 2, 2 * (1 - u), 2 * (1 - v), -2, 0, 0, -2};
}

}  // namespace

PatchTable::LeafPoint PatchTable::locate(const SurfaceParameter& place) const {
  double u = place.u, v = place.v;
  if (scheme_ == Scheme::loop) {
    const Index first = 4 * place.patch;
    if (u + v <= 0.5) return {first, 2 * u, 2 * v, 2, 0, 0, 2};
    if (u >= 0.5) return {first + 1, 2 * v, std::max(0.0, 2 * (1 - u - v)), 0, 2, -2, -2};
    if (v >= 0.5) return {first + 2, std::max(0.0, 2 * (1 - u - v)), 2 * u, -2, -2, 2, 0};
    return {first + 3, 2 * (u + v) - 1, 1 - 2 * u, 2, 2, -2, 0};
  }
  if (base_of_patch_.empty()) return quarter(place.patch, u, v);
  const Index base = base_of_patch_[place.patch];
  if (!split_patch_[place.patch]) return quarter(base, u, v);
  const LeafPoint outer = quarter(0, u, v);
  LeafPoint inner = quarter(base + outer.leaf, outer.s, outer.t);
  const LeafPoint by_quarter = inner;
  inner.s_u = by_quarter.s_u * outer.s_u + by_quarter.s_v * outer.t_u;
  inner.s_v = by_quarter.s_u * outer.s_v + by_quarter.s_v * outer.t_v;
  inner.t_u = by_quarter.t_u * outer.s_u + by_quarter.t_v * outer.t_u;
  inner.t_v = by_quarter.t_u * outer.s_v + by_quarter.t_v * outer.t_v;
  return inner;
}

}  // namespace gpsrecon
