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

/// Closes boundary loops of a surface one by one: triangulated with the least area among those that do not fold, refined
/// to the edge lengths around, and faired to run on smoothly (Liepa 2003; CGAL's Polygon_mesh_processing).
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
  /// only changes if the outcome is `closed`; new vertices are numbered from its number of vertices on. O(m² log m + n)
  /// for m edges, typically, O(m³) at worst.
  Outcome close(const std::vector<Index>& loop, const std::function<bool(const HolePatch&)>& wanted, HolePatch& patch);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gpsrecon
