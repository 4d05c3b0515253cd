#pragma once

#include <gpsrecon/core/mesh.h>
#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace gpsrecon {

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
  /// Copies the surface. Preconditions: triangles, manifold, consistently oriented.
  HolePatcher(const std::vector<Vec3>& positions, const FaceList& faces);
  ~HolePatcher();
  HolePatcher(HolePatcher&&) noexcept;
  HolePatcher& operator=(HolePatcher&&) noexcept;

  enum class Outcome {
    closed,        ///< the patch is part of the surface now
    no_patch,      ///< every triangulation of the loop has an edge that the surface has already, or a flat triangle
    intersecting,  ///< the patch would cut itself or the surface
    refused,       ///< by `wanted`
  };
  /// Patches the loop, a boundary as boundary_loops() gives it. `wanted` sees the patch before it is final. The surface
  /// only changes if the outcome is `closed`. O(m² log m + n) for m edges, typically, O(m³) at worst.
  Outcome close(const std::vector<Index>& loop, const std::function<bool(const HolePatch&)>& wanted, HolePatch& patch);

  /// Cuts out the places where the surface intersects itself, each with a few rings of faces around, and patches them,
  /// where that helps. A place at a boundary, or whose surroundings are no disc, stays as it is. Calls `replaced` with
  /// the rim of every place and its patch. O(n log² n), and O(n) for each place.
  void untangle(const std::function<void(const std::vector<Index>& rim, const HolePatch&)>& replaced);

  /// The surface as it is now.
  FaceList faces() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gpsrecon
