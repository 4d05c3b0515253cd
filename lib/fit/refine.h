#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/fit/residuals.h>

namespace gpsrecon {

/// The control edges (numbered as in triangle_connectivity) where the points show detail that the control mesh cannot
/// follow: the residuals, weighted by the basis function that a vertex on the edge would have, add up to more than
/// chance lets them. Edges with fewer than four points there, and boundary edges, are left alone.
std::vector<char> edges_with_detail(const LimitSurface& surface, const TriangleConnectivity& topology,
                                    const Residuals& residuals);

/// Splits the marked edges and, for the shape of the triangles, the longest edge of every triangle that loses one
/// (Rivara 1984), so that no angle falls below half of the smallest there was. Triangles with three split edges become
/// four, as in a Loop step; new vertices come at the end with the Gaussian that a Loop step puts on their edge, and
/// old ones move towards their place after a Loop step by the share of their edges that are split. The total weight
/// stays: a new vertex takes a share from the ends of its edge. O(n).
/// Throws InvariantError as triangle_connectivity.
CovMesh split_edges(const CovMesh& mesh, const TriangleConnectivity& topology, std::vector<char> marked,
                    const RunContext& context = {});

}  // namespace gpsrecon
