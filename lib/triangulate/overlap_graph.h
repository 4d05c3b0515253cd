#pragma once

#include <gpsrecon/core/gaussian.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/run_context.h>
#include <span>
#include <vector>

namespace gpsrecon::internal {

/// Pairs of Gaussians that overlap enough to share an edge, as sorted adjacency lists.
struct OverlapGraph {
  struct Link {
    Index to;
    double log_overlap;  ///< ln BC <= 0
  };
  std::vector<std::size_t> offset{0};  ///< links of component i: links[offset[i] .. offset[i + 1])
  std::vector<Link> links;             ///< ascending by `to` within a component

  std::span<const Link> operator[](Index i) const { return {links.data() + offset[i], links.data() + offset[i + 1]}; }
  /// ln BC of two components, or nullptr if they overlap too little. O(log k).
  const double* find(Index i, Index j) const;
};

/// All pairs with Bhattacharyya coefficient >= min_overlap (Preiner et al. 2019, Eq. 19). O(n k log n).
OverlapGraph overlap_graph(const Mixture& mixture, double min_overlap, const RunContext& context);

/// The graph without the links i -> j for which keep(i, j) is false. Precondition: keep is symmetric. O(links).
template <class Keep>
OverlapGraph kept_links(const OverlapGraph& graph, const Keep& keep) {
  OverlapGraph kept;
  kept.offset.reserve(graph.offset.size());
  kept.links.reserve(graph.links.size());
  for (Index i = 0; i + 1 < graph.offset.size(); ++i) {
    for (const OverlapGraph::Link& link : graph[i])
      if (keep(i, link.to)) kept.links.push_back(link);
    kept.offset.push_back(kept.links.size());
  }
  return kept;
}

}  // namespace gpsrecon::internal
