#include <gpsrecon/triangulate/light_components.h>
#include <algorithm>

namespace gpsrecon {

std::vector<Index> light_components(const Mixture& mixture, const OverlapGraph& graph, double share) {
  std::vector<Index> light;
  std::vector<double> around;
  for (Index i = 0; i < mixture.size(); ++i) {
    around.clear();
    for (const OverlapGraph::Link& link : graph[i]) around.push_back(mixture.weights[link.to]);
    if (around.empty()) continue;
    const auto median = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
    std::nth_element(around.begin(), median, around.end());
    if (mixture.weights[i] < share * *median) light.push_back(i);
  }
  return light;
}

OverlapGraph without(const OverlapGraph& graph, const std::vector<Index>& components) {
  const std::size_t n = graph.offset.size() - 1;
  std::vector<char> dropped(n, 0);
  for (const Index i : components) dropped[i] = 1;
  OverlapGraph kept;
  kept.offset.reserve(n + 1);
  kept.links.reserve(graph.links.size());
  for (Index i = 0; i < n; ++i) {
    if (!dropped[i])
      for (const OverlapGraph::Link& link : graph[i])
        if (!dropped[link.to]) kept.links.push_back(link);
    kept.offset.push_back(kept.links.size());
  }
  return kept;
}

}  // namespace gpsrecon
