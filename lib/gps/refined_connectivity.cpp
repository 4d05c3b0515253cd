// Loop 1987 (one triangle to four); Catmull & Clark 1978 (a quadrilateral per corner).

#include <gpsrecon/gps/refined_connectivity.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/parallel.h>
#include <string>
#include <utility>

namespace gpsrecon::internal {
namespace {

/// Half-edges of the child along half-edge h of the parent: the first half leaves the source of h in the corner
/// triangle there, the second half reaches its target in the corner triangle of that.
Index first_half(Index h) {
  return 12 * (h / 3) + 3 * (h % 3);
}
Index second_half(const Connectivity& parent, Index h) {
  return first_half(parent.next(h)) + 2;
}

/// Per face three corner triangles (vertex, after, before) and the one between.
void fill_triangles(const Connectivity& parent, std::vector<Index>& corners, const RunContext& context) {
  const auto vertices = static_cast<Index>(parent.vertex_count);
  parallel_for(parent.corners.size() / 3, context, [&](std::size_t f) {
    const auto base = static_cast<Index>(12 * f);
    for (Index j = 0; j < 3; ++j) {
      const auto h = static_cast<Index>(3 * f + j);
      const Index after = vertices + parent.edge[h];
      corners[base + 3 * j] = parent.corners[h];
      corners[base + 3 * j + 1] = after;
      corners[base + 3 * j + 2] = vertices + parent.edge[parent.previous(h)];
      corners[base + 9 + j] = after;
    }
  });
}

void fill_quads(const Connectivity& parent, std::vector<Index>& corners, const RunContext& context) {
  const auto edges = static_cast<Index>(parent.vertex_count), faces = static_cast<Index>(edges + parent.edge_count());
  parallel_for(parent.corners.size(), context, [&](std::size_t i) {
    const auto h = static_cast<Index>(i);
    corners[4 * i] = parent.corners[h];
    corners[4 * i + 1] = edges + parent.edge[h];
    corners[4 * i + 2] = faces + parent.face(h);
    corners[4 * i + 3] = edges + parent.edge[parent.previous(h)];
  });
}

/// All faces of n corners.
FaceList uniform_faces(std::vector<Index> corners, std::size_t n, const RunContext& context) {
  FaceList faces;
  faces.corners = std::move(corners);
  faces.offsets.resize(faces.corners.size() / n + 1);
  parallel_for(faces.offsets.size(), context,
               [&](std::size_t f) { faces.offsets[f] = static_cast<std::uint32_t>(n * f); });
  return faces;
}

Connectivity sized(std::size_t vertices, std::size_t edges, std::size_t half_edges, Index corners_per_face) {
  Connectivity c;
  c.vertex_count = vertices;
  c.corners_per_face = corners_per_face;
  c.corners.resize(half_edges);
  c.opposite.resize(half_edges);
  c.edge.resize(half_edges);
  c.edge_start.resize(edges);
  c.vertex_start.resize(vertices);
  c.face_count.resize(vertices);
  return c;
}

}  // namespace

void check_triangles(const Connectivity& connectivity) {
  for (Index f = 0; connectivity.corners_per_face != 3 && f < connectivity.face_total(); ++f)
    if (connectivity.face_size(f) != 3)
      throw InvariantError("subdivision: face " + std::to_string(f) + " has " +
                           std::to_string(connectivity.face_size(f)) +
                           " corners; Loop's scheme refines triangles (Catmull and Clark's refines any)");
}

Connectivity triangle_connectivity(const FaceList& faces, std::size_t vertex_count) {
  Connectivity connectivity = build_connectivity(faces, vertex_count);
  check_triangles(connectivity);
  const std::string faults = manifold_faults(connectivity);
  if (!faults.empty()) throw InvariantError("subdivision: " + faults);
  return connectivity;
}

Connectivity refine_triangles(const Connectivity& parent, const RunContext& context) {
  const std::size_t vertices = parent.vertex_count, edges = parent.edge_count(), faces = parent.face_total();
  Connectivity child = sized(vertices + edges, 2 * edges + 3 * faces, 12 * faces, 3);

  const auto set_edge = [&child](std::size_t e, Index h) {
    child.edge_start[e] = h;
    child.edge[h] = static_cast<Index>(e);
    if (child.opposite[h] != no_index) child.edge[child.opposite[h]] = static_cast<Index>(e);
  };
  fill_triangles(parent, child.corners, context);
  parallel_for(faces, context, [&](std::size_t f) {
    const auto base = static_cast<Index>(12 * f);
    for (Index j = 0; j < 3; ++j) {
      const auto h = static_cast<Index>(3 * f + j);
      const Index opposite = parent.opposite[h];
      // The middle half-edge of the corner triangle, after -> before, faces one of the inner triangle.
      const Index corner = base + 3 * j, inner = base + 9 + (j + 2) % 3;
      child.opposite[corner + 1] = inner;
      child.opposite[inner] = corner + 1;
      child.opposite[first_half(h)] = opposite == no_index ? no_index : second_half(parent, opposite);
      child.opposite[second_half(parent, h)] = opposite == no_index ? no_index : first_half(opposite);
    }
  });
  parallel_for(edges, context, [&](std::size_t e) {
    const Index h = parent.edge_start[e];
    set_edge(2 * e, first_half(h));
    set_edge(2 * e + 1, second_half(parent, h));
    // The edge's own vertex leaves along the second half, which lies on the boundary if the edge does.
    child.vertex_start[vertices + e] = second_half(parent, h);
    child.face_count[vertices + e] = parent.opposite[h] == no_index ? 3 : 6;
  });
  parallel_for(faces, context, [&](std::size_t f) {
    for (std::size_t j = 0; j < 3; ++j) set_edge(2 * edges + 3 * f + j, static_cast<Index>(12 * f + 9 + j));
  });
  parallel_for(vertices, context, [&](std::size_t v) {
    const Index h = parent.vertex_start[v];
    child.vertex_start[v] = h == no_index ? no_index : first_half(h);
    child.face_count[v] = parent.face_count[v];
  });
  return child;
}

FaceList refined_triangles(const Connectivity& parent, const RunContext& context) {
  std::vector<Index> corners(4 * parent.corners.size());
  fill_triangles(parent, corners, context);
  return uniform_faces(std::move(corners), 3, context);
}

Connectivity refine_to_quads(const Connectivity& parent, const RunContext& context) {
  const std::size_t vertices = parent.vertex_count, edges = parent.edge_count(), faces = parent.face_total(),
                    half_edges = parent.corners.size();
  Connectivity child = sized(vertices + edges + faces, 2 * edges + half_edges, 4 * half_edges, 4);
  fill_quads(parent, child.corners, context);
  parallel_for(half_edges, context, [&](std::size_t i) {
    const auto h = static_cast<Index>(i), q = 4 * h;
    const Index next = parent.next(h), before = parent.previous(h);
    const Index right = parent.opposite[h], left = parent.opposite[before];
    child.opposite[q] = right == no_index ? no_index : 4 * parent.next(right) + 3;
    child.opposite[q + 1] = 4 * next + 2;
    child.opposite[q + 2] = 4 * before + 1;
    child.opposite[q + 3] = left == no_index ? no_index : 4 * left;
    // Edges: both halves of every old one, then one from the middle of every half-edge into its face.
    const auto inner = static_cast<Index>(2 * edges + i);
    child.edge[q + 1] = child.edge[4 * next + 2] = inner;
    child.edge_start[inner] = q + 1;
  });
  parallel_for(edges, context, [&](std::size_t e) {
    const Index h = parent.edge_start[e], other = parent.opposite[h];
    const auto first = static_cast<Index>(2 * e);
    const Index leaving = 4 * h,
                arriving = 4 * parent.next(h) + 3;  // from the source, and from the middle to the target
    child.edge_start[first] = leaving;
    child.edge_start[first + 1] = arriving;
    child.edge[leaving] = first;
    child.edge[arriving] = first + 1;
    if (other != no_index) {
      child.edge[4 * parent.next(other) + 3] = first;
      child.edge[4 * other] = first + 1;
    }
    // On the boundary this is the one without opposite.
    child.vertex_start[vertices + e] = arriving;
    child.face_count[vertices + e] = other == no_index ? 2 : 4;
  });
  parallel_for(faces, context, [&](std::size_t i) {
    const auto f = static_cast<Index>(i);
    child.vertex_start[vertices + edges + i] = 4 * parent.face_start(f) + 2;
    child.face_count[vertices + edges + i] = parent.face_size(f);
  });
  parallel_for(vertices, context, [&](std::size_t v) {
    const Index h = parent.vertex_start[v];
    child.vertex_start[v] = h == no_index ? no_index : 4 * h;
    child.face_count[v] = parent.face_count[v];
  });
  return child;
}

FaceList refined_quads(const Connectivity& parent, const RunContext& context) {
  std::vector<Index> corners(4 * parent.corners.size());
  fill_quads(parent, corners, context);
  return uniform_faces(std::move(corners), 4, context);
}

}  // namespace gpsrecon::internal
