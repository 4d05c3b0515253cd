#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/triangulate/triangulate.h>
#include <vector>

namespace gpsrecon::internal {

/// What was done to a surface, and what became of its boundary loops.
struct Mending {
  std::size_t untangled = 0;       ///< self-intersecting regions replaced
  std::size_t handles = 0;         ///< small handles removed
  std::size_t filled = 0;          ///< loops closed
  std::size_t rims = 0;            ///< of these, outer rims of open sheets
  std::size_t new_vertices = 0;    ///< made for them that faces use
  std::vector<LoopReason> reason;  ///< per vertex of the mesh; of the loop it is on, where it is still on one
};

/// Replaces regions where the surface intersects itself and removes small handles, then fills boundary loops as
/// options.holes says, shortest first: with triangles over new vertices, which get Gaussians, flat in the patch, as
/// wide against the edges there as those of the rim are, and as thick as these, so that the smooth surface runs on; of
/// a weight that stands for no point. `component_of_vertex` is no_index for them. `mixture` holds the Gaussians that
/// may support a patch, used or left over. A patch that would cut the surface, or double an edge, is not made. The mesh
/// stays manifold and oriented; vertices may be left without faces. `connectivity` is that of the mesh as it comes.
Mending mend(CovMesh& mesh, const Connectivity& connectivity, std::vector<Index>& component_of_vertex,
             const Mixture& mixture, const TriangulateOptions& options, const RunContext& context = {});

}  // namespace gpsrecon::internal
