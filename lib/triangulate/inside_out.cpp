// Signs along a maximum spanning forest: Hoppe et al. 1992.

#include <gpsrecon/triangulate/inside_out.h>

#include <gpsrecon/core/disjoint_sets.h>
#include <gpsrecon/triangulate/sheet_forest.h>
#include <algorithm>

namespace gpsrecon::internal {
namespace {

/// Smaller patches are left to the closing of pinholes.
constexpr std::size_t min_patch = 8;

/// Per component: 1 if the triangles around it show the side that most of its tree shows, -1 the other, 0 unknown.
std::vector<int> agreement(const GrowingSurface& surface, const OverlapGraph& graph,
                           const std::vector<Vec3>& sheet_normals) {
  const std::size_t n = sheet_normals.size();
  std::vector<Vec3> used(n, Vec3::Zero());
  for (Index v = 0; v < n; ++v)
    if (surface.used(v)) used[v] = sheet_normals[v];
  DisjointSets sets(n);
  for (const SheetLink& link : sheet_links(graph, used)) sets.join(link.a, link.b, link.sign);

  std::vector<int> shown(n, 0);
  std::vector<long> balance(n, 0);
  for (Index v = 0; v < n; ++v) {
    if (used[v].isZero(0)) continue;
    double side = 0;
    for (const Index t : surface.triangles_around(v)) side += surface.normal(t).dot(sheet_normals[v]);
    const DisjointSets::Root root = sets.root(v);
    shown[v] = side * root.sign < 0 ? -1 : 1;
    balance[root.index] += shown[v];
  }
  for (Index v = 0; v < n; ++v)
    if (shown[v] != 0 && balance[sets.find(v)] < 0) shown[v] = -shown[v];
  return shown;
}

}  // namespace

std::size_t turn_inside_out(GrowingSurface& surface, const OverlapGraph& graph,
                            const std::vector<Vec3>& sheet_normals) {
  const std::vector<int> shown = agreement(surface, graph, sheet_normals);
  const std::size_t slots = surface.triangle_slots();
  std::vector<char> wrong(slots, 0);
  for (Index t = 0; t < slots; ++t) {
    if (!surface.alive(t)) continue;
    int sum = 0;
    for (const Index v : surface.triangle(t)) sum += shown[v];
    wrong[t] = sum < 0 ? 1 : 0;
  }
  std::size_t turned = 0;
  std::vector<char> seen(slots, 0);
  for (Index first = 0; first < slots; ++first) {
    if (!wrong[first] || seen[first]) continue;
    std::vector<Index> patch{first}, neck;
    std::size_t open = 0;
    seen[first] = 1;
    for (std::size_t k = 0; k < patch.size(); ++k) {
      const GrowingSurface::Triangle corners = surface.triangle(patch[k]);
      for (std::size_t j = 0; j < 3; ++j) {
        const Index from = corners[j], to = corners[(j + 1) % 3];
        const Index other = surface.triangle_at(to, from);
        if (other == no_index) {
          ++open;
        } else if (!wrong[other]) {
          neck.push_back(from);
          neck.push_back(to);
        } else if (!seen[other]) {
          seen[other] = 1;
          patch.push_back(other);
        }
      }
    }
    // Two vertices per edge of the neck.
    if (patch.size() < min_patch || neck.size() >= open) continue;
    std::sort(neck.begin(), neck.end());
    std::vector<GrowingSurface::Triangle> kept;
    for (const Index t : patch) {
      const GrowingSurface::Triangle corners = surface.triangle(t);
      const bool at_neck = std::any_of(corners.begin(), corners.end(),
                                       [&](Index v) { return std::binary_search(neck.begin(), neck.end(), v); });
      if (!at_neck) kept.push_back({corners[0], corners[2], corners[1]});
      surface.remove(t);
    }
    for (const GrowingSurface::Triangle& t : kept) surface.add(t);
    turned += kept.size();
  }
  return turned;
}

}  // namespace gpsrecon::internal
