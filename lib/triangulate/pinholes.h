#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/triangulate/front.h>
#include <gpsrecon/triangulate/growing_surface.h>
#include <vector>

namespace gpsrecon::internal {

/// Closes boundary loops of at most options.max_pinhole_edges edges with triangles between vertices that overlap, where
/// possible around a component that is still unused. Returns the number of loops closed.
std::size_t close_pinholes(GrowingSurface& surface, const Mixture& mixture, const OverlapGraph& graph,
                           const Sheets& sheets, const TriangulateOptions& options);

}  // namespace gpsrecon::internal
