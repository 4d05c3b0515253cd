// Exact evaluation near irregular vertices: Stam 1998 (Catmull-Clark) and 1999 (Loop), by refinement in place of
// powers.

#include <gpsrecon/gps/patch_table.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/leaf_points.h>
#include <gpsrecon/gps/refinement_levels.h>
#include <algorithm>
#include <iterator>
#include <map>
#include <string>

namespace gpsrecon::internal {
namespace {

/// Calls visit(old vertex, weight) for what the new vertex r of a refinement step is made of. Old vertices may repeat.
template <class FaceRows, class PointRows, class Visit>
void for_each_source(const RefinementStep<FaceRows, PointRows>& step, std::size_t r, const Visit& visit) {
  std::vector<Index> room(longest_row(step.points) + longest_row(step.faces));
  const auto visit_face = [&](std::size_t f, double factor) {
    const Row<double> row = read_row(step.faces, f, room.data() + longest_row(step.points));
    for (std::size_t j = 0; j < row.indices.size(); ++j) visit(row.indices[j], factor * row.weights[j]);
  };
  if (r >= step.points.rows()) return visit_face(r - step.points.rows(), 1);
  const std::size_t old = column_count(step.faces);
  const Row<double> row = read_row(step.points, r, room.data());
  for (std::size_t j = 0; j < row.indices.size(); ++j) {
    if (row.indices[j] < old)
      visit(row.indices[j], row.weights[j]);
    else
      visit_face(row.indices[j] - old, row.weights[j]);
  }
}

/// The same for a point of leaves, of which those from vertex_count on lie beyond the boundary.
template <class Visit>
void for_each_vertex(std::span<const PatchTable::Ghost> ghosts, std::size_t vertex_count, Index point, double factor,
                     const Visit& visit) {
  if (point < vertex_count) return visit(point, factor);
  const PatchTable::Ghost& ghost = ghosts[point - vertex_count];
  for_each_vertex(ghosts, vertex_count, ghost.plus[0], factor, visit);
  for_each_vertex(ghosts, vertex_count, ghost.plus[1], factor, visit);
  for_each_vertex(ghosts, vertex_count, ghost.minus, -factor, visit);
}

// The refinement of a leaf --------------------------------------------------------------------------------------------

/// An entry of a transposed map.
struct Entry {
  Index from, to;
  double weight;
};

/// Entries of the same row and column are added. Row 0 stays empty.
StencilTable table_of(std::vector<Entry> entries, Index rows, std::size_t columns) {
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
  StencilTable table;
  table.columns = columns;
  std::size_t e = 0;
  while (e < entries.size() && entries[e].from == 0) ++e;
  for (Index row = 0; row < rows; ++row) {
    const std::size_t begin = table.indices.size();
    table.masks.push_back(static_cast<std::uint32_t>(begin));
    for (; e < entries.size() && entries[e].from == row; ++e) {
      if (table.indices.size() > begin && table.indices.back() == entries[e].to) {
        table.weights.back() += entries[e].weight;
      } else {
        table.indices.push_back(entries[e].to);
        table.weights.push_back(entries[e].weight);
      }
    }
    table.offsets.push_back(static_cast<std::uint32_t>(table.indices.size()));
  }
  return table;
}

/// n faces around vertex 0, with triangles and with quadrilaterals.
FaceList fan_of(Index n, bool boundary, bool triangles) {
  FaceList faces;
  const Index step = triangles ? 1 : 2, around = step * n;
  for (Index i = 0; i < n; ++i) {
    const Index first = 1 + step * i, last = boundary || i + 1 < n ? first + step : first + step - around;
    if (triangles)
      faces.add(0, first, last);
    else
      faces.add(std::array{Index{0}, first, first + 1, last});
  }
  return faces;
}

/// The masks of a leaf are found where those of all refinement are: in the rows of the scheme. In the refinement of a
/// fan its face `at` has all points of such a leaf, and the refinement of that has those of the leaf half the size and
/// of the three regular faces beside it.
template <class Scheme>
class Fan {
 public:
  /// n faces around vertex 0.
  Fan(Index n, bool boundary, const SurfaceRules& rules) : n_(n), boundary_(boundary), rules_(rules) {}

  /// One in the interior, where the faces differ by a turn, otherwise one for each face.
  std::vector<PatchTable::Kind> kinds() {
    std::vector<PatchTable::Kind> kinds;
    for (Index at = 0; at < (boundary_ ? n_ : 1); ++at) kinds.push_back(kind(at));
    return kinds;
  }

 private:
  PatchTable::Kind kind(Index at) {
    // The first children of a face and of its half-edge.
    const Index size = coarse_.corners_per_face, h = 4 * size * at, half = 4 * h;
    PatchTable::Kind kind;
    kind.faces = n_;
    kind.boundary = boundary_;
    std::vector<Index> points;
    kind.own_count = add_points(before_, coarse_, h, points);
    const auto count = static_cast<Index>(points.size());
    kind.ring_count = count - kind.own_count;
    // Where points of the leaf are the same, as around two triangles back to back, either may stand for them.
    std::vector<Index> index_in_leaf(coarse_.vertex_count, no_index);
    for (Index i = count; i-- > 0;) index_in_leaf[points[i]] = i;
    std::vector<Index> refined;
    add_points(after_, fine_, half, refined);
    kind.step = transposed(refined, index_in_leaf, count);
    for (Index child = 1; child < 4; ++child) {
      // The half-edge along the first axis of the leaf, in the child between triangles against it.
      const Index first = child == 3 && size == 3 ? 1 : size - child;
      std::vector<Index> patch;
      after_.add_patch(half + size * child + first, patch);
      kind.patches[child - 1] = transposed(patch, index_in_leaf, count);
    }
    const auto limits = Scheme::limit(coarse_, rules_, false);
    std::vector<Index> room(longest_row(limits));
    const Row<LimitWeight> limit = read_row(limits, 0, room.data());
    kind.limit.assign(count, 0);
    for (std::size_t j = 0; j < limit.indices.size(); ++j)
      kind.limit[index_in_leaf[limit.indices[j]]] += limit.weights[j].position;
    return kind;
  }

  Index add_points(const LeafPoints& leaf, const Connectivity& mesh, Index h, std::vector<Index>& points) const {
    leaf.add_own(h, points);
    const auto own = static_cast<Index>(points.size());
    leaf.add_ring(boundary_ ? mesh.vertex_start[0] : h, points, [](Index) {});
    return own;
  }

  /// What the points of the leaf give to refined ones.
  StencilTable transposed(const std::vector<Index>& refined, const std::vector<Index>& index_in_leaf,
                          Index count) const {
    std::vector<Entry> entries;
    for (Index to = 0; to < refined.size(); ++to)
      for_each_vertex(after_.ghosts(), fine_.vertex_count, refined[to], 1, [&](Index r, double factor) {
        for_each_source(step_, r, [&](Index old, double weight) {
          if (index_in_leaf[old] == no_index) throw InvariantError("evaluation: a leaf does not refine itself");
          entries.push_back({index_in_leaf[old], to, factor * weight});
        });
      });
    return table_of(std::move(entries), count, refined.size());
  }

  Connectivity connect() const {
    const FaceList faces = fan_of(n_, boundary_, rules_.scheme == gpsrecon::Scheme::loop);
    return build_connectivity(faces, 1 + *std::max_element(faces.corners.begin(), faces.corners.end()));
  }

  Index n_;
  bool boundary_;
  SurfaceRules rules_;
  Connectivity coarse_ = Scheme::refine(connect(), {}), fine_ = Scheme::refine(coarse_, {});
  LeafPoints before_{coarse_, rules_}, after_{fine_, rules_};
  decltype(Scheme::step(coarse_, rules_)) step_ = Scheme::step(coarse_, rules_);
};

}  // namespace

// The leaves of a mesh ------------------------------------------------------------------------------------------------

template <class Scheme>
void PatchTable::build(const Connectivity& base, const SurfaceRules& rules, const RunContext& context) {
  base_limit_ = tabulate(Scheme::limit(base, rules, false), context);
  to_points_ = tabulate(Scheme::step(base, rules), context);
  const Connectivity mesh = Scheme::refine(base, context);
  LeafPoints points(mesh, rules);
  const Index size = mesh.corners_per_face, per_spoke = size - 2;
  const auto faces = static_cast<Index>(mesh.face_total());
  leaves_.reserve(faces);
  std::vector<Index> ring(base.vertex_count, no_index), number(faces, 0);
  std::vector<std::vector<Index>> around(base.vertex_count);
  std::map<std::pair<Index, bool>, std::size_t> first_kind;
  for (Index f = 0; f < faces; ++f) {
    const Index h = size * f, v = mesh.corners[h];
    const auto begin = [&] { return static_cast<std::uint32_t>(indices_.size()); };
    if (points.regular(v)) {
      leaves_.push_back({0, begin(), 0});
      points.add_patch(h, indices_);
      continue;
    }
    if (v >= base.vertex_count) throw InvariantError("evaluation: an inner vertex of a face is not regular");
    const Index count = mesh.face_count[v];
    const bool boundary = mesh.on_boundary(v);
    if (ring[v] == no_index) {
      // In the interior twice, so that it is one piece from each leaf on.
      ring[v] = begin();
      Index n = 0;
      points.add_ring(mesh.vertex_start[v], indices_, [&](Index g) { number[mesh.face(g)] = n++; });
      if (!boundary)
        for (Index i = 0; i < per_spoke * (count - 1); ++i) indices_.push_back(indices_[ring[v] + i]);
    }
    around[v].push_back(f);
    const auto [first, added] = first_kind.try_emplace({count, boundary}, kinds_.size());
    if (added) {
      std::vector<Kind> kinds = Fan<Scheme>(count, boundary, rules).kinds();
      std::move(kinds.begin(), kinds.end(), std::back_inserter(kinds_));
    }
    const auto kind = static_cast<std::uint32_t>(first->second);
    leaves_.push_back(boundary ? Leaf{kind + number[f], begin(), ring[v]}
                               : Leaf{kind, begin(), ring[v] + per_spoke * number[f]});
    points.add_own(h, indices_);
  }
  ghosts_ = points.ghosts();
  fan_offsets_.assign(1, 0);
  for (const std::vector<Index>& leaves : around) {
    fan_leaves_.insert(fan_leaves_.end(), leaves.begin(), leaves.end());
    fan_offsets_.push_back(static_cast<Index>(fan_leaves_.size()));
  }
}

PatchTable::PatchTable(const FaceList& faces, std::size_t control_count, const SurfaceRules& rules,
                       const RunContext& context)
    : PatchTable(manifold_connectivity(faces, control_count, "subdivision"), rules, context) {}

PatchTable::PatchTable(const Connectivity& control, const SurfaceRules& rules, const RunContext& context)
    : scheme_(rules.scheme), control_count_(control.vertex_count), patch_count_(control.face_total()) {
  if (scheme_ == Scheme::loop) {
    check_triangles(control);
    build<LoopScheme>(control, rules, context);
    return;
  }
  std::optional<Connectivity> refined;
  if (control.corners_per_face != 4) {
    // One patch per corner, or the four around the middle of a quadrilateral in one.
    for (Index f = 0; f < control.face_total(); ++f) {
      const Index first = control.face_start(f), n = control.face_size(f);
      first_patch_.push_back(static_cast<Index>(base_of_patch_.size()));
      for (Index i = 0; i < (n == 4 ? 1 : n); ++i) {
        base_of_patch_.push_back(first + i);
        split_patch_.push_back(n == 4);
      }
    }
    patch_count_ = base_of_patch_.size();
    to_base_ = tabulate(CatmullClarkScheme::step(control, rules), context);
    refined = CatmullClarkScheme::refine(control, context);
  }
  build<CatmullClarkScheme>(refined ? *refined : control, rules, context);
}

// Parameters
// --------------------------------------------------------------------------------------------------------------

void PatchTable::check(std::span<const SurfaceParameter> parameters) const {
  // Sums of exact parameters may be one off in the last place.
  constexpr double slack = 1e-12;
  for (const SurfaceParameter& p : parameters) {
    const double top = triangular() ? p.u + p.v : std::max(p.u, p.v);
    if (p.patch >= patch_count() || !(p.u >= 0 && p.v >= 0 && top <= 1 + slack))
      throw OptionError("no parameter of the surface: patch " + std::to_string(p.patch) + " of " +
                        std::to_string(patch_count()) + ", u = " + std::to_string(p.u) +
                        ", v = " + std::to_string(p.v));
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

PatchTable::LeafPoint PatchTable::locate(const SurfaceParameter& parameter) const {
  double u = parameter.u, v = parameter.v;
  if (scheme_ == Scheme::loop) {
    const Index first = 4 * parameter.patch;
    if (u + v <= 0.5) return {first, 2 * u, 2 * v, 2, 0, 0, 2};
    if (u >= 0.5) return {first + 1, 2 * v, std::max(0.0, 2 * (1 - u - v)), 0, 2, -2, -2};
    if (v >= 0.5) return {first + 2, std::max(0.0, 2 * (1 - u - v)), 2 * u, -2, -2, 2, 0};
    return {first + 3, 2 * (u + v) - 1, 1 - 2 * u, 2, 2, -2, 0};
  }
  if (base_of_patch_.empty()) return quarter(parameter.patch, u, v);
  const Index base = base_of_patch_[parameter.patch];
  if (!split_patch_[parameter.patch]) return quarter(base, u, v);
  const LeafPoint outer = quarter(0, u, v);
  LeafPoint inner = quarter(base + outer.leaf, outer.s, outer.t);
  const LeafPoint by_quarter = inner;
  inner.s_u = by_quarter.s_u * outer.s_u + by_quarter.s_v * outer.t_u;
  inner.s_v = by_quarter.s_u * outer.s_v + by_quarter.s_v * outer.t_v;
  inner.t_u = by_quarter.t_u * outer.s_u + by_quarter.t_v * outer.t_u;
  inner.t_v = by_quarter.t_u * outer.s_v + by_quarter.t_v * outer.t_v;
  return inner;
}

// Weights -------------------------------------------------------------------------------------------------------------

namespace {

/// By (u, v) instead of (s, t), which themselves are seen `scale` times as large.
void change_parameters(const PatchTable::LeafPoint& point, double scale, BasisWeight<2>& w) {
  const double su = scale * point.s_u, sv = scale * point.s_v, tu = scale * point.t_u, tv = scale * point.t_v;
  const double s = w[1], t = w[2], ss = w[3], st = w[4], tt = w[5];
  w[1] = su * s + tu * t;
  w[2] = sv * s + tv * t;
  w[3] = su * su * ss + 2 * su * tu * st + tu * tu * tt;
  w[4] = su * sv * ss + (su * tv + sv * tu) * st + tu * tv * tt;
  w[5] = sv * sv * ss + 2 * sv * tv * st + tv * tv * tt;
}
void change_parameters(const PatchTable::LeafPoint&, double, double&) {}

template <int Order>
BasisWeight<Order> sum_of_weights() {
  if constexpr (Order == 0)
    return 1;
  else
    return BasisWeight<2>::Unit(0);
}

/// weights = table refined, for a transposed map, and the weight of point 0 from the sum.
template <int Order>
void pull_back(const StencilTable& table, const std::vector<BasisWeight<Order>>& refined,
               std::vector<BasisWeight<Order>>& weights) {
  weights.resize(table.rows());
  BasisWeight<Order> rest = sum_of_weights<Order>();
  for (std::size_t i = 1; i < weights.size(); ++i) {
    weights[i] = apply_row<BasisWeight<Order>>(table.row(i), refined);
    rest -= weights[i];
  }
  weights[0] = rest;
}

}  // namespace

template <int Order>
void PatchTable::irregular_weights(const LeafPoint& point, PatchRow<Order>& row) const {
  const Leaf& leaf = leaves_[point.leaf];
  const Kind& kind = kinds_[leaf.kind];
  if (extraordinary(point)) {
    if constexpr (Order == 0) {
      row.weights = kind.limit;
    } else {
      LeafPoint off = point;
      off.s = off.t = leaf_offset;
      irregular_weights(off, row);
      for (std::size_t i = 0; i < row.weights.size(); ++i) row.weights[i][0] = kind.limit[i];
    }
    return;
  }
  double s = 2 * point.s, t = 2 * point.t, scale = 2;
  int steps = 0;
  for (; triangular() ? s + t < 1 : s < 1 && t < 1; ++steps) s *= 2, t *= 2, scale *= 2;
  const auto begin = [&](const auto& basis, std::size_t patch, double factor) {
    row.refined.assign(basis.begin(), basis.end());
    for (BasisWeight<Order>& w : row.refined) change_parameters(point, factor, w);
    pull_back<Order>(kind.patches[patch], row.refined, row.weights);
  };
  if (triangular()) {
    // The face that continues the edge to (1, 0), that to (0, 1), or the one between, which is upside down.
    if (s >= 1)
      begin(box_spline_basis<Order>(s - 1, t), 0, scale);
    else if (t >= 1)
      begin(box_spline_basis<Order>(s, t - 1), 1, scale);
    else
      begin(box_spline_basis<Order>(1 - s, 1 - t), 2, -scale);
  } else {
    const int i = s >= 1 ? 1 : 0, j = t >= 1 ? 1 : 0;
    begin(bicubic_basis<Order>(s - i, t - j), i == 0 ? 2 : j == 0 ? 0 : 1, scale);
  }
  for (; steps > 0; --steps) {
    row.refined.swap(row.weights);
    pull_back<Order>(kind.step, row.refined, row.weights);
  }
}

template <int Order>
void PatchTable::point_weights(const LeafPoint& point, PatchRow<Order>& row) const {
  const Leaf& leaf = leaves_[point.leaf];
  const std::span<const Index> points = points_of(leaf);
  row.indices.assign(points.begin(), points.end());
  if (leaf.kind != 0) {
    const std::span<const Index> ring = ring_of(leaf);
    row.indices.insert(row.indices.end(), ring.begin(), ring.end());
    return irregular_weights(point, row);
  }
  const auto begin = [&](const auto& basis) {
    row.weights.assign(basis.begin(), basis.end());
    for (BasisWeight<Order>& w : row.weights) change_parameters(point, 1, w);
  };
  if (triangular())
    begin(box_spline_basis<Order>(point.s, point.t));
  else
    begin(bicubic_basis<Order>(point.s, point.t));
}

template void PatchTable::point_weights<0>(const LeafPoint&, PatchRow<0>&) const;
template void PatchTable::point_weights<2>(const LeafPoint&, PatchRow<2>&) const;

namespace {

/// The weights of vertices, once each, ascending.
class VertexWeights {
 public:
  struct Item {
    Index vertex;
    BasisWeight<2> weight;
  };
  const std::vector<Item>& items() const { return items_; }

  /// Those of old vertices, `sources(item, add)` telling of what a vertex is made.
  template <class Sources>
  void replace(const Sources& sources) {
    from_.swap(items_);
    items_.clear();
    for (const Item& item : from_)
      sources(item.vertex, [&](Index old, double weight) { items_.push_back({old, weight * item.weight}); });
    merge();
  }
  void assign(const PatchRow<2>& row) {
    items_.clear();
    for (std::size_t i = 0; i < row.indices.size(); ++i) items_.push_back({row.indices[i], row.weights[i]});
    merge();
  }

 private:
  void merge() {
    std::stable_sort(items_.begin(), items_.end(), [](const Item& a, const Item& b) { return a.vertex < b.vertex; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      if (kept > 0 && items_[kept - 1].vertex == items_[i].vertex)
        items_[kept - 1].weight += items_[i].weight;
      else
        items_[kept++] = items_[i];
    }
    items_.resize(kept);
  }

  std::vector<Item> items_, from_;
};

}  // namespace

JetTable PatchTable::weights(std::span<const SurfaceParameter> parameters, const RunContext& context) const {
  check(parameters);
  constexpr std::size_t block_size = 512;
  std::vector<JetTable> blocks((parameters.size() + block_size - 1) / block_size);
  const auto compute = [&](std::size_t block, std::size_t begin, std::size_t end) {
    JetTable& table = blocks[block];
    PatchRow<2> row;
    VertexWeights weights;
    for (std::size_t i = begin; i < end; ++i) {
      point_weights(locate(parameters[i]), row);
      weights.assign(row);
      weights.replace(
          [&](Index point, const auto& add) { for_each_vertex(ghosts_, to_points_.new_vertices(), point, 1, add); });
      weights.replace([&](Index vertex, const auto& add) { for_each_source(to_points_, vertex, add); });
      if (to_base_) weights.replace([&](Index vertex, const auto& add) { for_each_source(*to_base_, vertex, add); });
      for (const auto& [vertex, w] : weights.items()) {
        table.indices.push_back(vertex);
        table.weights.push_back({w[0], w[1], w[2], w[3], w[4], w[5]});
      }
      table.offsets.push_back(static_cast<std::uint32_t>(table.indices.size()));
    }
  };
  parallel_blocks(parameters.size(), context, compute, block_size);
  JetTable table;
  table.columns = control_count_;
  for (const JetTable& block : blocks) {
    const auto first = static_cast<std::uint32_t>(table.indices.size());
    for (std::size_t i = 0; i + 1 < block.offsets.size(); ++i) {
      table.masks.push_back(first + block.offsets[i]);
      table.offsets.push_back(first + block.offsets[i + 1]);
    }
    table.indices.insert(table.indices.end(), block.indices.begin(), block.indices.end());
    table.weights.insert(table.weights.end(), block.weights.begin(), block.weights.end());
  }
  return table;
}

}  // namespace gpsrecon::internal
