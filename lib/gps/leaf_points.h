#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/gps/patch_table.h>
#include <vector>

// Internal to lib/gps: the points that the surface over a face depends on.

namespace gpsrecon::internal {

/// Walks around the faces of a mesh, all of three or all of four corners, of which at most the first is not regular.
class LeafPoints {
 public:
  /// The connectivity must outlive it.
  LeafPoints(const Connectivity& connectivity, const SurfaceRules& rules)
      : mesh_(connectivity),
        triangles_(rules.scheme == Scheme::loop),
        sharp_corners_(rules.corners == CornerRule::sharp) {}

  bool regular(Index vertex) const;

  /// The points of the patch of the face of h, the start of h at (0, 0) and its end at (1, 0). Those beyond the
  /// boundary are numbered from the number of vertices on. Precondition: all its vertices are regular.
  void add_patch(Index h, std::vector<Index>& to) { triangles_ ? add_triangle_patch(h, to) : add_quad_patch(h, to); }
  /// The points beyond the boundary, of all patches so far.
  const std::vector<PatchTable::Ghost>& ghosts() const { return ghosts_; }

  /// The start of h, and what lies around the other vertices of its face but around the start of h.
  void add_own(Index h, std::vector<Index>& to) const;
  /// What lies around the start of h, counter-clockwise from the end of h on. Calls visit(g) for its faces.
  template <class Visit>
  void add_ring(Index h, std::vector<Index>& to, const Visit& visit) const {
    const Index arriving = mesh_.for_each_in_fan(h, [&](Index g) {
      visit(g);
      to.push_back(target(g));
      if (!triangles_) to.push_back(target(next(g)));
    });
    if (arriving != no_index) to.push_back(source(arriving));
  }

 private:
  Index next(Index h) const { return mesh_.next(h); }
  Index previous(Index h) const { return mesh_.previous(h); }
  Index opposite(Index h) const { return mesh_.opposite[h]; }
  Index source(Index h) const { return mesh_.source(h); }
  Index target(Index h) const { return mesh_.target(h); }

  Index reflected(Index a, Index b, Index inner);
  std::array<Index, 6> neighbors(Index h, int first);
  void add_triangle_patch(Index h, std::vector<Index>& to);
  void add_quad_patch(Index h, std::vector<Index>& to);

  const Connectivity& mesh_;
  bool triangles_, sharp_corners_;
  std::vector<PatchTable::Ghost> ghosts_;
};

}  // namespace gpsrecon::internal
