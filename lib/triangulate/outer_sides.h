#pragma once

#include <gpsrecon/core/run_context.h>
#include <gpsrecon/triangulate/overlap_graph.h>
#include <vector>

namespace gpsrecon::internal {

/// Per component of a mixture a unit normal to the outer side of the surface, by ambient occlusion (exposure.h):
/// zero where that is unknown, and on surfaces that are not closed, whose two sides are both outer ones; there the side
/// that the points were seen from, if the mixture knows it. The normals of
/// flat components (`sheet_normals`, zero for others) get their signs along a maximum spanning forest of their
/// overlaps; trees of it are not joined if exposure tells that they show opposite sides, as the two of a thin sheet or
/// the walls of a crevice do. Creases and tips have their bent normals. A surface counts as closed if, over a connected
/// part of the graph, one side gets at least three times the light of the other. Measured on scans: closed surfaces 15
/// to 20 times, with gaps from few views 6 to 9 times, a vase and a room open at one side 4 times, scans from a single
/// view 1.1 to 1.5 times. O(n k log n).
std::vector<Vec3> outer_normals(const Mixture& mixture, const OverlapGraph& graph,
                                const std::vector<Vec3>& sheet_normals, const RunContext& context);

/// The same from where the surface was seen: that side is the outer one. `outward` has a vector per
/// component, as Mixture::outward: where it is short its points disagree, and where it is nearly at right angles to the
/// normal noise would decide; there, and on creases and tips, the normal is zero. Then neighbours
/// decide: components without a side take the one that those overlapping them have, by their overlap, as long as there
/// are any. O(n k).
std::vector<Vec3> outer_normals(const std::vector<Vec3>& outward, const OverlapGraph& graph,
                                const std::vector<Vec3>& sheet_normals);

/// The graph without the links between components that face opposite ways (by more than 120°).
OverlapGraph without_opposed(const OverlapGraph& graph, const std::vector<Vec3>& outer_normals);

}  // namespace gpsrecon::internal
