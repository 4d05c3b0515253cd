#pragma once

#include <gpsrecon/core/mesh.h>
#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace gpsrecon::internal {

/// What closes a hole.
struct HolePatch {
  std::vector<Vec3> positions;              ///< of new vertices
  std::vector<std::array<Index, 3>> faces;  ///< corners from `first_new` on are the new vertices, in order
  Index first_new = 0;
};

/// Closes boundary loops of a surface one by one: triangulated with the least area among those that do not fold,
/// refined to the edge lengths around, and faired to run on smoothly (Liepa 2003; CGAL's Polygon_mesh_processing). New
/// vertices are numbered from the number of vertices on.
class HolePatcher {
 public:
  /// Copies the surface. Precondition: triangles. Throws InvariantError unless manifold and consistently oriented.
  HolePatcher(const std::vector<Vec3>& positions, const FaceList& faces);
  ~HolePatcher();
  HolePatcher(HolePatcher&&) noexcept;
  HolePatcher& operator=(HolePatcher&&) noexcept;

  /// Sees a patch before it is final.
  using Wanted = std::function<bool(const HolePatch&)>;
  /// Is told every rim, in its order around the patch, that has a patch now.
  using Replaced = std::function<void(const std::vector<Index>& rim, const HolePatch&)>;

  enum class Outcome {
    closed,        ///< the patch is part of the surface now
    gone,          ///< the loop was closed before, with another
    no_patch,      ///< every triangulation of the loop has an edge that the surface has already, or a flat triangle
    intersecting,  ///< the patch would cut itself or the surface
    refused,       ///< by `wanted`
  };
  /// Patches the loop, a boundary as boundary_loops() gives it; if its patch is wanted but will not do, together with
  /// up to a few rings of the faces along it, if the surface stays as connected as it is. The surface only changes if
  /// the outcome is `closed`. O(m² log m + n) for m edges, typically, O(m³) at worst.
  Outcome close(const std::vector<Index>& loop, const Wanted& wanted, const Replaced& replaced);

  /// Cuts out the regions where the surface intersects itself, each with a few rings of faces around, and patches them,
  /// where that helps. A region at a boundary, or whose surroundings are no disc, stays as it is. O(n log² n), and O(n)
  /// for each region.
  void untangle(const Replaced& replaced);

  /// Takes a handle away: cuts out the faces around a loop, with up to a few rings of faces more, and patches the holes
  /// that leaves. Nothing changes, and the answer is false, unless the surface has fewer handles then and is as
  /// connected as it was, and every patch is `wanted` and intersects nothing. O(n).
  bool cut(const std::vector<Index>& loop, const Wanted& wanted, const Replaced& replaced);

  /// The surface as it is now.
  FaceList faces() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gpsrecon::internal
