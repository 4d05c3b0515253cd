#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/gps/connectivity.h>

namespace gpsrecon {

/// Half-edges of a triangle mesh, made to be refined without sorting: half-edge h lies in triangle h / 3, and
/// one-to-four refinement gives every array of the child in closed form.
struct TriangleConnectivity : Connectivity {
  static Index next(Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static Index previous(Index h) { return h % 3 == 0 ? h + 2 : h - 1; }
  Index target(Index h) const { return corners[next(h)]; }

  /// Calls visit(h, arriving) for a half-edge of every edge at v counter-clockwise: of those that leave v, and on the
  /// boundary of the last that arrives there.
  template <class Visit>
  void for_each_edge(Index v, const Visit& visit) const {
    const Index start = vertex_start[v];
    if (start == no_index) return;
    Index h = start;
    do {
      visit(h, false);
      const Index before = previous(h);
      h = opposite[before];
      if (h == no_index) return visit(before, true);
    } while (h != start);
  }
  /// Calls visit(r) for the neighbours of v counter-clockwise: face_count[v] of them in the interior, one more on the
  /// boundary, from the target of the leaving boundary edge to the source of the arriving one.
  template <class Visit>
  void for_each_neighbor(Index v, const Visit& visit) const {
    for_each_edge(v, [&](Index h, bool arriving) { visit(arriving ? source(h) : target(h)); });
  }
};

/// Throws InvariantError unless the faces are triangles, and as connectivity. O(c log c) in the number of corners.
TriangleConnectivity triangle_connectivity(const FaceList& faces, std::size_t vertex_count);

/// One-to-four refinement. Vertices of the parent keep their index; the vertex on edge e is vertex_count + e. Face f
/// with corners a, b, c becomes 4f: (a, ab, ca), 4f + 1: (b, bc, ab), 4f + 2: (c, ca, bc), 4f + 3: (ab, bc, ca). O(n).
TriangleConnectivity refine(const TriangleConnectivity& parent, const RunContext& context = {});

/// The faces of refine(parent) alone. O(n).
FaceList refined_faces(const TriangleConnectivity& parent, const RunContext& context = {});

}  // namespace gpsrecon
