#include <gpsrecon/core/error.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/gps/triangle_connectivity.h>

namespace gpsrecon {
namespace {

using Topo = TriangleConnectivity;

/// Half-edges of the child along half-edge h of the parent: the first half leaves the source of h in the corner
/// triangle there, the second half reaches its target in the corner triangle of that.
Index first_half(Index h) {
  return 12 * (h / 3) + 3 * (h % 3);
}
Index second_half(Index h) {
  return first_half(Topo::next(h)) + 2;
}

/// Per face three corner triangles (vertex, after, before) and the one between.
void fill_refined_corners(const Topo& parent, std::vector<Index>& corners, const RunContext& context) {
  const auto vertices = static_cast<Index>(parent.vertex_count);
  parallel_for(parent.corners.size() / 3, context, [&](std::size_t f) {
    const auto base = static_cast<Index>(12 * f);
    for (Index j = 0; j < 3; ++j) {
      const auto h = static_cast<Index>(3 * f + j);
      const Index after = vertices + parent.edge[h];
      corners[base + 3 * j] = parent.corners[h];
      corners[base + 3 * j + 1] = after;
      corners[base + 3 * j + 2] = vertices + parent.edge[Topo::previous(h)];
      corners[base + 9 + j] = after;
    }
  });
}

}  // namespace

TriangleConnectivity triangle_connectivity(const FaceList& faces, std::size_t vertex_count) {
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (faces[f].size() != 3)
      throw InvariantError("subdivision: face " + std::to_string(f) + " has " + std::to_string(faces[f].size()) +
                           " corners; Loop's scheme refines triangles (Catmull and Clark's refines any)");
  return {connectivity(faces, vertex_count)};
}

TriangleConnectivity refine(const TriangleConnectivity& parent, const RunContext& context) {
  const std::size_t vertices = parent.vertex_count, edges = parent.edge_count(), faces = parent.corners.size() / 3;
  Topo child;
  child.vertex_count = vertices + edges;
  child.corners.resize(12 * faces);
  child.opposite.resize(12 * faces);
  child.edge.resize(12 * faces);
  child.edge_start.resize(2 * edges + 3 * faces);
  child.vertex_start.resize(child.vertex_count);
  child.face_count.resize(child.vertex_count);

  const auto set_edge = [&child](std::size_t e, Index h) {
    child.edge_start[e] = h;
    child.edge[h] = static_cast<Index>(e);
    if (child.opposite[h] != no_index) child.edge[child.opposite[h]] = static_cast<Index>(e);
  };
  fill_refined_corners(parent, child.corners, context);
  parallel_for(faces, context, [&](std::size_t f) {
    const auto base = static_cast<Index>(12 * f);
    for (Index j = 0; j < 3; ++j) {
      const auto h = static_cast<Index>(3 * f + j);
      const Index opposite = parent.opposite[h];
      // The middle half-edge of the corner triangle, after -> before, faces one of the inner triangle.
      const Index corner = base + 3 * j, inner = base + 9 + (j + 2) % 3;
      child.opposite[corner + 1] = inner;
      child.opposite[inner] = corner + 1;
      child.opposite[first_half(h)] = opposite == no_index ? no_index : second_half(opposite);
      child.opposite[second_half(h)] = opposite == no_index ? no_index : first_half(opposite);
    }
  });
  parallel_for(edges, context, [&](std::size_t e) {
    const Index h = parent.edge_start[e];
    set_edge(2 * e, first_half(h));
    set_edge(2 * e + 1, second_half(h));
    // The edge's own vertex leaves along the second half, which lies on the boundary if the edge does.
    child.vertex_start[vertices + e] = second_half(h);
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

FaceList refined_faces(const TriangleConnectivity& parent, const RunContext& context) {
  FaceList faces;
  faces.corners.resize(4 * parent.corners.size());
  fill_refined_corners(parent, faces.corners, context);
  faces.offsets.resize(faces.corners.size() / 3 + 1);
  parallel_for(faces.offsets.size(), context,
               [&](std::size_t f) { faces.offsets[f] = static_cast<std::uint32_t>(3 * f); });
  return faces;
}

}  // namespace gpsrecon
