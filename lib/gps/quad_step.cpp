#include <gpsrecon/gps/manifold_edges.h>
#include <gpsrecon/gps/quad_step.h>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace gpsrecon {
namespace {

void find_starts(PolygonEdges& e) {
  e.start.assign(e.vertex_count, no_index);
  e.face_count.assign(e.vertex_count, 0);
  for (Index h = 0; h < e.corners.size(); ++h) {
    const Index v = e.corners[h];
    if (e.start[v] == no_index || e.opposite[h] == no_index) e.start[v] = h;
    ++e.face_count[v];
  }
}

bool same(double a, double b) {
  return a == b;
}
bool same(const LimitWeight& a, const LimitWeight& b) {
  return a.position == b.position && a.u == b.u && a.v == b.v;
}

/// A row under construction.
template <class Weight>
struct Row {
  std::vector<Index> indices;
  std::vector<Weight> weights;
  std::vector<std::uint32_t> last_mask;  ///< per length, plus one: the mask of the last row of that length; 0 = none
  void add(Index i, const Weight& w) {
    indices.push_back(i);
    weights.push_back(w);
  }
  void append_to(Stencils<Weight>& table) {
    // Nearly all rows of one length have the same weights: they share a mask.
    if (last_mask.size() <= weights.size()) last_mask.resize(weights.size() + 1, 0);
    std::uint32_t& known = last_mask[weights.size()];
    const bool shared = known > 0 && std::equal(weights.begin(), weights.end(), table.weights.begin() + (known - 1),
                                                [](const Weight& a, const Weight& b) { return same(a, b); });
    if (!shared) known = table.add_mask(weights) + 1;
    table.add_row(known - 1, weights.size());
    table.indices.insert(table.indices.end(), indices.begin(), indices.end());
    indices.clear();
    weights.clear();
  }
};

Index face_size(const PolygonEdges& e, Index h) {
  Index n = 0, g = h;
  do {
    ++n;
    g = e.next[g];
  } while (g != h);
  return n;
}

void add_face(const PolygonEdges& e, Index h, double weight, Row<double>& row) {
  const double share = weight / face_size(e, h);
  Index g = h;
  do {
    row.add(e.corners[g], share);
    g = e.next[g];
  } while (g != h);
}

/// Calls visit(h) for the half-edges leaving v, counter-clockwise; returns the one that arrives last on a boundary.
template <class Visit>
Index for_each_leaving(const PolygonEdges& e, Index v, const Visit& visit) {
  Index h = e.start[v];
  do {
    visit(h);
    const Index arriving = e.previous[h];
    h = e.opposite[arriving];
    if (h == no_index) return arriving;
  } while (h != e.start[v]);
  return no_index;
}

bool kept(const PolygonEdges& e, Index v, CornerRule corners) {
  return e.unused(v) || (e.on_boundary(v) && e.face_count[v] == 1 && corners == CornerRule::sharp);
}

void add_vertex_row(const PolygonEdges& e, Index v, CornerRule corners, Row<double>& row) {
  if (kept(e, v, corners)) return row.add(v, 1);
  if (e.on_boundary(v)) {
    row.add(v, 3.0 / 4);
    row.add(e.target(e.start[v]), 1.0 / 8);
    row.add(e.corners[for_each_leaving(e, v, [](Index) {})], 1.0 / 8);
    return;
  }
  // (F + 2R + (n - 3) v) / n with the averages F of the face points and R of the middles of the edges
  const double n = e.face_count[v];
  row.add(v, (n - 2) / n);
  for_each_leaving(e, v, [&](Index h) {
    row.add(e.target(h), 1 / (n * n));
    add_face(e, h, 1 / (n * n), row);
  });
}

LimitWeight weight(double position, double u = 0, double v = 0) {
  return {position, u, v};
}

/// The weights of the inner edges and faces are A sin(iθ) and sin(iθ) + sin((i + 1)θ), those of a fan of 2k faces in
/// the interior; the columns of v and of the boundary edges give the other two.
struct BoundaryMode {
  double a, theta, of_vertex, of_edge;
  explicit BoundaryMode(Index k) {
    theta = std::numbers::pi / k;
    const double c = std::cos(theta), root = std::cos(theta / 2) * std::sqrt(2 * (9 + c));
    a = 1 + c + root;
    const double lambda = (5 + c + root) / 16;
    double edges = 0, faces = 0;
    for (Index i = 0; i < k; ++i) {
      edges += edge(i);
      faces += face(i);
    }
    const double p = edge(1) / 16 + face(0) / 4, q = 3 * edges / 8 + faces / 4;
    // (λ - 1/2) b - v/8 = p, (λ - 3/4) v - b = q
    of_vertex = (p + (lambda - 0.5) * q) / ((lambda - 0.5) * (lambda - 0.75) - 0.125);
    of_edge = (lambda - 0.75) * of_vertex - q;
  }
  double edge(Index i) const { return a * std::sin(i * theta); }
  double face(Index i) const { return std::sin(i * theta) + std::sin((i + 1) * theta); }
};

void add_limit_row(const PolygonEdges& e, Index v, CornerRule corners, Row<LimitWeight>& row) {
  if (e.unused(v)) return row.add(v, weight(1));
  const Index n = e.face_count[v];
  if (!e.on_boundary(v)) {
    const double step = 2 * std::numbers::pi / n, c = std::cos(step), count = n;
    const double a = 1 + c + std::cos(step / 2) * std::sqrt(2 * (9 + c));
    row.add(v, weight(count / (count + 5)));
    Index i = 0;
    for_each_leaving(e, v, [&](Index h) {
      const double t0 = i * step, t1 = (i + 1) * step;
      row.add(e.target(h), weight(4 / (count * (count + 5)), a * std::cos(t0), a * std::sin(t0)));
      row.add(e.target(e.next[h]),
              weight(1 / (count * (count + 5)), std::cos(t0) + std::cos(t1), std::sin(t0) + std::sin(t1)));
      ++i;
    });
    return;
  }
  const Index first = e.target(e.start[v]), last = e.corners[for_each_leaving(e, v, [](Index) {})];
  if (kept(e, v, corners)) {
    row.add(v, weight(1, -1, -1));
    row.add(first, weight(0, 1, 0));
    row.add(last, weight(0, 0, 1));
  } else if (n == 1) {
    // What is left across the boundary is the curvature of the boundary curve.
    row.add(v, weight(2.0 / 3, 0, -2));
    row.add(first, weight(1.0 / 6, 1, 1));
    row.add(last, weight(1.0 / 6, -1, 1));
  } else {
    const BoundaryMode mode(n);
    row.add(v, weight(2.0 / 3, 0, mode.of_vertex));
    row.add(first, weight(1.0 / 6, 1, mode.of_edge));
    row.add(last, weight(1.0 / 6, -1, mode.of_edge));
    Index i = 0;
    for_each_leaving(e, v, [&](Index h) {
      if (i > 0) row.add(e.target(h), weight(0, 0, mode.edge(i)));
      row.add(e.target(e.next[h]), weight(0, 0, mode.face(i)));
      ++i;
    });
  }
}

}  // namespace

PolygonEdges polygon_edges(const FaceList& faces, std::size_t vertex_count) {
  HalfEdges half_edges = manifold_edges(faces, vertex_count);
  PolygonEdges edges;
  edges.vertex_count = vertex_count;
  edges.corners = faces.corners;
  edges.opposite = std::move(half_edges.opposite);
  edges.next = std::move(half_edges.next);
  edges.previous.resize(edges.next.size());
  for (Index h = 0; h < edges.next.size(); ++h) edges.previous[edges.next[h]] = h;
  find_starts(edges);
  return edges;
}

QuadStep catmull_clark_step(const PolygonEdges& old, CornerRule corners) {
  const auto half_edges = static_cast<Index>(old.corners.size());
  QuadStep step;
  StencilTable& table = step.stencils;
  table.columns = old.vertex_count;
  Row<double> row;
  for (Index v = 0; v < old.vertex_count; ++v) {
    add_vertex_row(old, v, corners, row);
    row.append_to(table);
  }
  std::vector<Index> edge(half_edges, no_index), face(half_edges, no_index);
  for (Index h = 0; h < half_edges; ++h) {
    const Index other = old.opposite[h];
    if (edge[h] != no_index) continue;
    edge[h] = static_cast<Index>(table.rows());
    if (other == no_index) {
      row.add(old.corners[h], 0.5);
      row.add(old.target(h), 0.5);
    } else {
      edge[other] = edge[h];
      row.add(old.corners[h], 0.25);
      row.add(old.target(h), 0.25);
      add_face(old, h, 0.25, row);
      add_face(old, other, 0.25, row);
    }
    row.append_to(table);
  }
  for (Index h = 0; h < half_edges; ++h) {
    if (face[h] != no_index) continue;
    const auto center = static_cast<Index>(table.rows());
    Index g = h;
    do {
      face[g] = center;
      g = old.next[g];
    } while (g != h);
    add_face(old, h, 1, row);
    row.append_to(table);
  }

  PolygonEdges& e = step.edges;
  e.vertex_count = table.rows();
  e.corners.resize(4 * half_edges);
  e.opposite.resize(4 * half_edges);
  e.next.resize(4 * half_edges);
  e.previous.resize(4 * half_edges);
  for (Index h = 0; h < half_edges; ++h) {
    const Index before = old.previous[h], q = 4 * h;
    const Index right = old.opposite[h], left = old.opposite[before];
    e.corners[q] = old.corners[h];
    e.corners[q + 1] = edge[h];
    e.corners[q + 2] = face[h];
    e.corners[q + 3] = edge[before];
    e.opposite[q] = right == no_index ? no_index : 4 * old.next[right] + 3;
    e.opposite[q + 1] = 4 * old.next[h] + 2;
    e.opposite[q + 2] = 4 * before + 1;
    e.opposite[q + 3] = left == no_index ? no_index : 4 * left;
    for (Index i = 0; i < 4; ++i) {
      e.next[q + i] = q + (i + 1) % 4;
      e.previous[q + i] = q + (i + 3) % 4;
    }
  }
  find_starts(e);
  return step;
}

LimitTable quad_limit_table(const PolygonEdges& quads, CornerRule corners) {
  LimitTable table;
  table.columns = quads.vertex_count;
  Row<LimitWeight> row;
  for (Index v = 0; v < quads.vertex_count; ++v) {
    add_limit_row(quads, v, corners, row);
    row.append_to(table);
  }
  return table;
}

}  // namespace gpsrecon
