#include <gpsrecon/triangulate/sheet_forest.h>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace gpsrecon {
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

SignedSets::SignedSets(std::size_t n) : parent_(n), sign_(n, 1) {
  std::iota(parent_.begin(), parent_.end(), Index{0});
}

SignedSets::Root SignedSets::find(Index v) {
  Index root = v;
  int sign = 1;
  while (parent_[root] != root) sign *= sign_[root], root = parent_[root];
  for (Index at = v, next; at != root; at = next) {  // path compression
    next = parent_[at];
    const int below = sign_[at];
    parent_[at] = root;
    sign_[at] = sign;
    sign *= below;
  }
  return {root, sign_[v]};
}

void SignedSets::join(Index a, Index b, int sign) {
  const Root ra = find(a), rb = find(b);
  parent_[rb.set] = ra.set;
  sign_[rb.set] = ra.sign * rb.sign * sign;
}

}  // namespace gpsrecon
