// Preiner et al. 2019, Eq. 18-19.

#include <gpsrecon/triangulate/overlap_graph.h>

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>

namespace gpsrecon::internal {
namespace {

constexpr std::size_t components_per_block = 256;

/// Found from the component with the larger extent, whose ball then bounds the distance of the pair.
struct Pair {
  Index i, j;
  double log_overlap;
};

}  // namespace

const double* OverlapGraph::find(Index i, Index j) const {
  const auto row = (*this)[i];
  const auto at = std::lower_bound(row.begin(), row.end(), j, [](const Link& l, Index to) { return l.to < to; });
  return at != row.end() && at->to == j ? &at->log_overlap : nullptr;
}

OverlapGraph overlap_graph(const Mixture& mixture, double min_overlap, const RunContext& context) {
  const std::size_t n = mixture.size();
  const double log_min = std::log(min_overlap);
  std::vector<FactoredGaussian> gaussians;
  gaussians.reserve(n);
  std::vector<double> extent(n);  // λmax
  for (std::size_t i = 0; i < n; ++i) gaussians.emplace_back(mixture.component(i));
  parallel_for(n, context, [&](std::size_t i) { extent[i] = largest_eigenvalue(mixture.covariances[i]); });

  const Neighbors index(mixture.means);
  std::vector<std::vector<Pair>> blocks((n + components_per_block - 1) / components_per_block);
  parallel_blocks(
      n, context,
      [&](std::size_t block, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t i = begin; i < end; ++i) {
          // BC <= exp(-|Δμ|² / (4 (λi + λj))) since the determinant factor is at most 1.
          index.within(mixture.means[i], std::sqrt(-8 * log_min * extent[i]), near);
          for (const Neighbor& neighbor : near) {
            const Index j = neighbor.index;
            if (extent[j] > extent[i] || (extent[j] == extent[i] && j >= i)) continue;
            if (neighbor.distance * neighbor.distance > -4 * log_min * (extent[i] + extent[j])) continue;
            const double log_overlap = log_bhattacharyya(gaussians[i], gaussians[j]);
            if (log_overlap >= log_min) blocks[block].push_back({static_cast<Index>(i), j, log_overlap});
          }
        }
      },
      components_per_block);

  OverlapGraph graph;
  graph.offset.assign(n + 1, 0);
  for (const auto& block : blocks)
    for (const Pair& pair : block) ++graph.offset[pair.i + 1], ++graph.offset[pair.j + 1];
  for (std::size_t i = 0; i < n; ++i) graph.offset[i + 1] += graph.offset[i];
  graph.links.resize(graph.offset[n]);
  std::vector<std::size_t> cursor(graph.offset.begin(), graph.offset.end() - 1);
  for (const auto& block : blocks)
    for (const Pair& pair : block) {
      graph.links[cursor[pair.i]++] = {pair.j, pair.log_overlap};
      graph.links[cursor[pair.j]++] = {pair.i, pair.log_overlap};
    }
  parallel_for(n, context, [&](std::size_t i) {
    std::sort(graph.links.begin() + static_cast<std::ptrdiff_t>(graph.offset[i]),
              graph.links.begin() + static_cast<std::ptrdiff_t>(graph.offset[i + 1]),
              [](const OverlapGraph::Link& a, const OverlapGraph::Link& b) { return a.to < b.to; });
  });
  return graph;
}

}  // namespace gpsrecon::internal
