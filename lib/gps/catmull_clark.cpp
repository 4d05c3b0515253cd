// Catmull & Clark 1978; boundary rules: the cubic B-spline (DeRose et al. 1998).

#include <gpsrecon/gps/catmull_clark.h>

#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gpsrecon::internal {
namespace {

using Topo = Connectivity;

constexpr std::array interior_edge_mask{1.0 / 4, 1.0 / 4, 1.0 / 4, 1.0 / 4};

/// The numbers of corners of all faces.
std::vector<Index> face_sizes(const Topo& topology) {
  if (topology.corners_per_face != 0) return {topology.corners_per_face};
  std::vector<Index> sizes(topology.face_total());
  for (Index f = 0; f < sizes.size(); ++f) sizes[f] = topology.face_size(f);
  return sizes;
}

/// Numbers of faces of interior vertices: those of the vertices, and if `refined` of the points of the faces.
std::vector<Index> limit_valences(const Topo& topology, bool refined) {
  std::vector<Index> counts = topology.face_count;
  if (refined) {
    const std::vector<Index> sizes = face_sizes(topology);
    counts.insert(counts.end(), sizes.begin(), sizes.end());
  }
  return counts;
}

std::vector<double> interior_vertex_mask(Index count) {
  const double n = count;
  std::vector<double> mask(2 * count + std::size_t{1}, 1 / (n * n));
  mask[0] = (n - 2) / n;
  return mask;
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

using LimitMask = std::vector<LimitWeight>;

/// Weights of v and, face by face, of the other end of the edge before it and of the opposite corner.
LimitMask interior_limit_mask(Index n) {
  const double step = 2 * std::numbers::pi / n, c = std::cos(step), count = n;
  const double a = 1 + c + std::cos(step / 2) * std::sqrt(2 * (9 + c));
  LimitMask mask(2 * n + std::size_t{1});
  mask[0] = weight(count / (count + 5));
  for (Index i = 0; i < n; ++i) {
    const double t0 = i * step, t1 = (i + 1) * step;
    mask[2 * i + std::size_t{1}] = weight(4 / (count * (count + 5)), a * std::cos(t0), a * std::sin(t0));
    mask[2 * i + std::size_t{2}] =
        weight(1 / (count * (count + 5)), std::cos(t0) + std::cos(t1), std::sin(t0) + std::sin(t1));
  }
  return mask;
}

/// Weights of v, of its neighbours on the boundary, first and last, of the opposite corner of the first face, and of
/// inner edge and opposite corner of every other.
LimitMask boundary_limit_mask(Index n) {
  // With one face, what is left across the boundary is the curvature of the boundary curve.
  if (n == 1) return {weight(2.0 / 3, 0, -2), weight(1.0 / 6, 1, 1), weight(1.0 / 6, -1, 1)};
  const BoundaryMode mode(n);
  LimitMask mask(2 * n + std::size_t{2});
  mask[0] = weight(2.0 / 3, 0, mode.of_vertex);
  mask[1] = weight(1.0 / 6, 1, mode.of_edge);
  mask[2] = weight(1.0 / 6, -1, mode.of_edge);
  for (Index i = 0; i < n; ++i) {
    if (i > 0) mask[2 * i + std::size_t{2}] = weight(0, 0, mode.edge(i));
    mask[2 * i + std::size_t{3}] = weight(0, 0, mode.face(i));
  }
  return mask;
}

}  // namespace

CatmullClarkFaceRows::CatmullClarkFaceRows(const Connectivity& connectivity)
    : connectivity_(connectivity),
      by_size_(masks_.add_by_count(face_sizes(connectivity), [](Index n) { return std::vector<double>(n, 1.0 / n); })) {
}

void CatmullClarkFaceRows::fill(std::size_t r, std::span<Index> row) const {
  std::copy_n(connectivity_.corners.begin() + connectivity_.face_start(static_cast<Index>(r)), row.size(), row.begin());
}

CatmullClarkRows::CatmullClarkRows(const Connectivity& connectivity, CornerRule corners)
    : StepRows(connectivity, corners, interior_edge_mask, interior_vertex_mask) {}

void CatmullClarkRows::fill(std::size_t r, std::span<Index> row) const {
  if (!interior_after_fill(r, row)) return;
  const Topo& topology = connectivity_;
  const auto vertices = static_cast<Index>(topology.vertex_count);
  if (r >= vertices) {
    row[2] = vertices + topology.face(half_edge(r));
    row[3] = vertices + topology.face(topology.opposite[half_edge(r)]);
    return;
  }
  std::size_t at = 1;
  topology.for_each_leaving(row[0], [&](Index h) {
    row[at++] = topology.target(h);
    row[at++] = vertices + topology.face(h);
  });
}

CatmullClarkLimitRows::CatmullClarkLimitRows(const Connectivity& connectivity, CornerRule corners, bool refined)
    : LimitRows(connectivity, corners, refined, 4, boundary_limit_mask, interior_limit_mask,
                limit_valences(connectivity, refined)) {}

std::size_t CatmullClarkLimitRows::rows() const {
  const Topo& topology = connectivity_;
  return topology.vertex_count + (refined_ ? topology.edge_count() + topology.face_total() : 0);
}

Mask CatmullClarkLimitRows::mask(std::size_t r) const {
  const std::size_t vertices = connectivity_.vertex_count, edges = connectivity_.edge_count();
  if (r < vertices) return vertex_mask(static_cast<Index>(r));
  if (r < vertices + edges) return edge_mask(r - vertices);
  return interior_mask(connectivity_.face_size(static_cast<Index>(r - vertices - edges)));
}

void CatmullClarkLimitRows::fill(std::size_t r, std::span<Index> row) const {
  const Topo& topology = connectivity_;
  const auto vertices = static_cast<Index>(topology.vertex_count), edges = static_cast<Index>(topology.edge_count());
  row[0] = static_cast<Index>(r);
  std::size_t at = 1;
  const auto edge_point = [&](Index h) { return vertices + topology.edge[h]; };
  const auto face_point = [&](Index h) { return vertices + edges + topology.face(h); };
  if (r >= vertices + edges) {
    const auto f = static_cast<Index>(r - vertices - edges);
    for (Index h = topology.face_start(f); h < topology.face_start(f + 1); ++h) {
      row[at++] = edge_point(topology.previous(h));
      row[at++] = topology.source(h);
    }
    return;
  }
  if (r >= vertices) {
    // Around the middle of an edge: its target, the next edge, the face, the edge before, its source; then the other
    // face.
    const Index h = topology.edge_start[r - vertices], other = topology.opposite[h];
    if (other == no_index) {
      row[1] = topology.target(h);
      row[2] = topology.source(h);
      row[3] = edge_point(topology.next(h));
      row[4] = face_point(h);
      row[5] = edge_point(topology.previous(h));
      return;
    }
    for (const Index g : {h, other}) {
      row[at++] = topology.target(g);
      row[at++] = edge_point(topology.next(g));
      row[at++] = face_point(g);
      row[at++] = edge_point(topology.previous(g));
    }
    return;
  }
  const auto v = static_cast<Index>(r);
  if (row.size() == 1) return;
  const auto end_of_edge = [&](Index h) { return refined_ ? edge_point(h) : topology.target(h); };
  const auto across_face = [&](Index h) { return refined_ ? face_point(h) : topology.target(topology.next(h)); };
  if (topology.on_boundary(v)) {
    const Index first = topology.vertex_start[v];
    const Index last = topology.for_each_leaving(v, [](Index) {});
    row[1] = end_of_edge(first);
    row[2] = refined_ ? edge_point(last) : topology.source(last);
    if (row.size() == 3) return;
    at = 3;
    topology.for_each_leaving(v, [&](Index h) {
      if (h != first) row[at++] = end_of_edge(h);
      row[at++] = across_face(h);
    });
    return;
  }
  topology.for_each_leaving(v, [&](Index h) {
    row[at++] = end_of_edge(h);
    row[at++] = across_face(h);
  });
}

}  // namespace gpsrecon::internal
