// Signs along a maximum spanning forest (Hoppe et al. 1992, Kruskal 1956), decided by exposure to light.

#include <gpsrecon/triangulate/outer_sides.h>

#include <gpsrecon/core/disjoint_sets.h>
#include <gpsrecon/core/exposure.h>
#include <gpsrecon/core/sheets.h>
#include <gpsrecon/triangulate/sheet_forest.h>
#include <algorithm>
#include <cmath>

namespace gpsrecon::internal {
namespace {

/// Trees whose light differs, between the sides, by less than what half a fully exposed component gets have no say.
constexpr double least_evidence = 0.5;
/// Least (lit - unlit) / (lit + unlit) of a closed surface.
constexpr double closed = 0.5;
constexpr double opposed = -0.5;

/// Light on flat components: on the side their normals point to minus that on the other, and both together.
struct Light {
  double difference = 0, total = 0;

  bool from_one_side() const { return std::abs(difference) > closed * total; }
  Light turned(int sign) const { return {sign * difference, total}; }
  Light& operator+=(const Light& other) {
    difference += other.difference;
    total += other.total;
    return *this;
  }
};

/// Both get light from one side, and not from the same.
bool face_opposite_ways(const Light& a, const Light& b) {
  return a.from_one_side() && b.from_one_side() && a.difference * b.difference < 0 &&
         std::min(std::abs(a.difference), std::abs(b.difference)) > least_evidence;
}

/// Numbers the connected parts of the graph.
std::vector<Index> connected_parts(const OverlapGraph& graph, std::size_t n) {
  std::vector<Index> part(n, no_index), stack;
  Index count = 0;
  for (Index first = 0; first < n; ++first) {
    if (part[first] != no_index) continue;
    stack.assign(1, first);
    part[first] = count;
    while (!stack.empty()) {
      const Index i = stack.back();
      stack.pop_back();
      for (const OverlapGraph::Link& link : graph[i])
        if (part[link.to] == no_index) part[link.to] = count, stack.push_back(link.to);
    }
    ++count;
  }
  return part;
}

}  // namespace

std::vector<Vec3> outer_normals(const std::vector<Vec3>& outward, const OverlapGraph& graph,
                                const std::vector<Vec3>& sheet_normals) {
  const std::size_t n = outward.size();
  std::vector<Vec3> outer(n, Vec3::Zero());
  std::vector<Index> open;
  for (Index i = 0; i < n; ++i) {
    if (sheet_normals[i].isZero(0)) continue;
    const double side = sheet_normals[i].dot(outward[i]);
    if (std::abs(side) > least_view)
      outer[i] = side < 0 ? Vec3(-sheet_normals[i]) : sheet_normals[i];
    else
      open.push_back(i);
  }
  // Rounds of those next to a side that is known, all at once, so that their order does not matter.
  while (!open.empty()) {
    std::vector<std::pair<Index, Vec3>> found;
    for (const Index i : open) {
      double side = 0;
      for (const OverlapGraph::Link& link : graph[i])
        side += std::exp(link.log_overlap) * sheet_normals[i].dot(outer[link.to]);
      if (side != 0) found.emplace_back(i, side < 0 ? Vec3(-sheet_normals[i]) : sheet_normals[i]);
    }
    if (found.empty()) break;
    for (const auto& [i, normal] : found) outer[i] = normal;
    std::erase_if(open, [&](Index i) { return !outer[i].isZero(0); });
  }
  return outer;
}

std::vector<Vec3> outer_normals(const Mixture& mixture, const OverlapGraph& graph,
                                const std::vector<Vec3>& sheet_normals, const RunContext& context) {
  const std::size_t n = mixture.size();
  const Exposure seen = exposure(mixture, context);
  std::vector<Light> light(n);
  for (Index i = 0; i < n; ++i) {
    if (sheet_normals[i].isZero(0)) continue;
    const double difference = seen.front[i] - seen.back[i];
    light[i] = {sheet_normals[i].dot(seen.axis[i]) < 0 ? -difference : difference, seen.front[i] + seen.back[i]};
  }

  DisjointSets sets(n);
  std::vector<Light> on_set = light;  // per root, signed like it
  for (const SheetLink& link : sheet_links(graph, sheet_normals)) {
    const DisjointSets::Root a = sets.root(link.a), b = sets.root(link.b);
    if (a.index == b.index) continue;
    const int sign = a.sign * b.sign * link.sign;
    if (face_opposite_ways(on_set[a.index], on_set[b.index].turned(sign))) continue;
    sets.join(link.a, link.b, link.sign);
    const Index root = sets.find(a.index), other = root == a.index ? b.index : a.index;
    on_set[root] += on_set[other].turned(sign);
  }

  const std::vector<Index> part = connected_parts(graph, n);
  std::vector<Light> on_part(n);
  for (Index i = 0; i < n; ++i)
    if (sets.find(i) == i) on_part[part[i]] += on_set[i].turned(on_set[i].difference < 0 ? -1 : 1);
  const std::vector<Vec3> by_view =
      mixture.outward.empty() ? std::vector<Vec3>() : outer_normals(mixture.outward, graph, sheet_normals);
  std::vector<Vec3> outer(n, Vec3::Zero());
  for (Index i = 0; i < n; ++i) {
    if (!on_part[part[i]].from_one_side()) {
      if (!by_view.empty()) outer[i] = by_view[i];
      continue;
    }
    if (sheet_normals[i].isZero(0)) {
      // On the rim of an open sheet light comes from all around.
      Light around;
      for (const OverlapGraph::Link& link : graph[i])
        around += light[link.to].turned(light[link.to].difference < 0 ? -1 : 1);
      if (around.from_one_side()) outer[i] = seen.bent_normal[i].stableNormalized();
    } else {
      const DisjointSets::Root root = sets.root(i);
      outer[i] = (on_set[root.index].difference < 0 ? -root.sign : root.sign) * sheet_normals[i];
    }
  }
  return outer;
}

OverlapGraph without_opposed(const OverlapGraph& graph, const std::vector<Vec3>& outer_normals) {
  return kept_links(graph, [&](Index i, Index j) { return outer_normals[i].dot(outer_normals[j]) >= opposed; });
}

}  // namespace gpsrecon::internal
