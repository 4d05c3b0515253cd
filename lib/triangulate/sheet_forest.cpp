// Maximum spanning forest: Kruskal 1956; signs along it: Hoppe et al. 1992.

#include <gpsrecon/triangulate/sheet_forest.h>
#include <algorithm>
#include <cmath>

namespace gpsrecon::internal {
namespace {

/// Normals at a larger angle say little about each other's sign.
constexpr double parallel = 0.7;

}  // namespace

std::vector<SheetLink> sheet_links(const OverlapGraph& graph, std::span<const Vec3> normals) {
  std::vector<SheetLink> links;
  for (Index a = 0; a < normals.size(); ++a)
    for (const OverlapGraph::Link& link : graph[a]) {
      if (link.to <= a) continue;
      const double cosine = normals[a].dot(normals[link.to]);
      if (std::abs(cosine) > parallel)
        links.push_back({link.log_overlap + std::log(std::abs(cosine)), a, link.to, cosine < 0 ? -1 : 1});
    }
  std::sort(links.begin(), links.end(), [](const SheetLink& x, const SheetLink& y) {
    if (x.log_strength != y.log_strength) return x.log_strength > y.log_strength;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  return links;
}

}  // namespace gpsrecon::internal
