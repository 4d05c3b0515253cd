#include <gpsrecon/triangulate/light_components.h>

#include <gpsrecon/core/order_statistics.h>

namespace gpsrecon::internal {

std::vector<Index> light_components(const Mixture& mixture, const OverlapGraph& graph, double share) {
  std::vector<Index> light;
  std::vector<double> around;
  for (Index i = 0; i < mixture.size(); ++i) {
    around.clear();
    for (const OverlapGraph::Link& link : graph[i]) around.push_back(mixture.weights[link.to]);
    if (around.empty()) continue;
    if (mixture.weights[i] < share * median(around)) light.push_back(i);
  }
  return light;
}

OverlapGraph without(const OverlapGraph& graph, const std::vector<Index>& components) {
  std::vector<char> dropped(graph.offset.size() - 1, 0);
  for (const Index i : components) dropped[i] = 1;
  return kept_links(graph, [&](Index i, Index j) { return !dropped[i] && !dropped[j]; });
}

}  // namespace gpsrecon::internal
