#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/run_context.h>
#include <vector>

namespace gpsrecon::internal {

/// Sum of the genera of the connected components of a manifold, oriented surface: the number of its handles.
std::size_t genus(const Connectivity& connectivity);

/// Simple closed paths of at most `max_edges` edges along which the surface can be cut without falling apart: each runs
/// around a handle, or through one. Per vertex these are the shortest of a basis of the loops through it that stay
/// within max_edges / 2 edges of it (Erickson and Whittlesey 2005, greedy homotopy basis). Shortest first, none twice;
/// a handle may have many. Preconditions: triangles, manifold, consistently oriented. Nothing to do without handles:
/// O(n) then; else O(n b log b) for b vertices within reach of a vertex, and the faces met when looking for a way
/// around.
std::vector<std::vector<Index>> handle_loops(const std::vector<Vec3>& positions, const FaceList& faces,
                                             std::size_t max_edges, const RunContext& context = {});

}  // namespace gpsrecon::internal
