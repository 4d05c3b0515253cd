#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/fit/residuals.h>

namespace gpsrecon::internal {

/// Per control edge (numbered as in build_connectivity) the evidence that the points show detail there that the
/// control mesh cannot follow: the squared sum of the residuals, weighted by the basis function that a vertex on the
/// edge would have, in units of what chance lets it be. 0 if it is below the threshold, for edges with fewer than four
/// points there, and for boundary edges.
std::vector<double> edges_with_detail(const LimitSurface& surface, const Connectivity& topology,
                                      const Residuals& residuals);

/// The edges to split where there is evidence, with the longest edges that split_edges() adds to them: all, or in the
/// order of falling evidence those that at most `most` splits suffice for, equal ones by index. O(n log n).
std::vector<char> strongest_edges(const CovMesh& mesh, const Connectivity& topology,
                                  const std::vector<double>& evidence, std::size_t most);

/// Splits the marked edges and, for the shape of the triangles, the longest edge of every triangle that loses one
/// (Rivara 1984), so that no angle falls below half of the smallest there was. Triangles with three split edges become
/// four, as in a Loop step; new vertices come at the end with the Gaussian that a Loop step puts on their edge, and
/// old ones move towards their position after a Loop step by the share of their edges that are split. The total weight
/// stays: a new vertex takes a share from the ends of its edge. O(n).
/// Throws InvariantError as triangle_connectivity.
CovMesh split_edges(const CovMesh& mesh, const Connectivity& topology, std::vector<char> marked,
                    const RunContext& context = {});

}  // namespace gpsrecon::internal
