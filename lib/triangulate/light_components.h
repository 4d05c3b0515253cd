#pragma once

#include <gpsrecon/triangulate/overlap_graph.h>

namespace gpsrecon::internal {

/// Components with less than `share` of the median weight of those that overlap them, ascending: single points and
/// small groups off the surface, which never merged with it. In a sheet they would not be missed: the others overlap
/// there. Components that overlap none are not among them. O(n k log k).
std::vector<Index> light_components(const Mixture& mixture, const OverlapGraph& graph, double share);

/// The graph without the links of `components`, which keep their number. O(links).
OverlapGraph without(const OverlapGraph& graph, const std::vector<Index>& components);

}  // namespace gpsrecon::internal
