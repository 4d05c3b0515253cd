#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/triangulate/overlap_graph.h>
#include <vector>

namespace gpsrecon::internal {

// `connectivity` is that of `faces`, before and after.

/// Gives every fan of a vertex but the largest a vertex of its own: a copy of the component with its share of the
/// weight, moved a little into its fan, so that welding equal positions does not join them again. Appends to `vertices`
/// and `component_of_vertex`. Returns the number of copies.
std::size_t split_vertices(Mixture& vertices, std::vector<Index>& component_of_vertex, FaceList& faces,
                           Connectivity& connectivity);

struct DroppedComponents {
  std::size_t count = 0;  ///< components of faces removed
  double weight = 0;      ///< of the vertices that no face uses any more
};
/// Removes connected components of faces whose vertices carry less than `min_share` of the weight of the mixture, and
/// closed ones of less than ten times that which overlap a heavier one in every vertex: what was left of a sheet that
/// the rest closed over makes such bubbles. The heaviest component stays. `graph` may be empty.
DroppedComponents drop_small_components(const Mixture& vertices, const OverlapGraph& graph, FaceList& faces,
                                        Connectivity& connectivity, double min_share);

}  // namespace gpsrecon::internal
