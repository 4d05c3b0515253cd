#include <gpsrecon/core/exposure.h>
#include <gpsrecon/triangulate/outer_sides.h>
#include <gpsrecon/triangulate/sheet_forest.h>
#include <cmath>

namespace gpsrecon {
namespace {

/// Trees whose light differs, between the sides, by less than what half a fully exposed component gets have no say.
constexpr double least_evidence = 0.5;
/// (lit - unlit) / (lit + unlit), where light reaches one side of a closed surface.
constexpr double closed = 0.75;
constexpr double opposed = -0.5;

/// Light on the flat components of each set, signed like its root: front minus back, and both together.
struct Light {
  std::vector<double> difference, total;
};

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

std::vector<Vec3> outer_normals(const Mixture& mixture, const OverlapGraph& graph,
                                const std::vector<Vec3>& sheet_normals, const RunContext& context) {
  const std::size_t n = mixture.size();
  const Exposure seen = exposure(mixture, context);
  Light light{std::vector<double>(n, 0), std::vector<double>(n, 0)};
  for (Index i = 0; i < n; ++i) {
    if (sheet_normals[i].isZero(0)) continue;
    const double difference = seen.front[i] - seen.back[i];
    light.difference[i] = sheet_normals[i].dot(seen.axis[i]) < 0 ? -difference : difference;
    light.total[i] = seen.front[i] + seen.back[i];
  }

  SignedSets sets(n);
  for (const SheetLink& link : sheet_links(graph, sheet_normals)) {
    const SignedSets::Root a = sets.find(link.a), b = sets.find(link.b);
    if (a.set == b.set) continue;
    const int sign = a.sign * b.sign * link.sign;
    const double on_a = light.difference[a.set], on_b = sign * light.difference[b.set];
    if (on_a * on_b < 0 && std::min(std::abs(on_a), std::abs(on_b)) > least_evidence) continue;
    sets.join(link.a, link.b, link.sign);
    light.difference[a.set] = on_a + on_b;
    light.total[a.set] += light.total[b.set];
  }

  const std::vector<Index> part = connected_parts(graph, n);
  std::vector<double> difference(n, 0), total(n, 0);  // per part
  for (Index i = 0; i < n; ++i) {
    if (sheet_normals[i].isZero(0) || sets.find(i).set != i) continue;
    difference[part[i]] += std::abs(light.difference[i]);
    total[part[i]] += light.total[i];
  }
  std::vector<Vec3> outer(n, Vec3::Zero());
  for (Index i = 0; i < n; ++i) {
    if (!(difference[part[i]] > closed * total[part[i]])) continue;
    if (sheet_normals[i].isZero(0)) {
      outer[i] = seen.bent_normal[i].stableNormalized();
    } else {
      const SignedSets::Root root = sets.find(i);
      outer[i] = (light.difference[root.set] < 0 ? -root.sign : root.sign) * sheet_normals[i];
    }
  }
  return outer;
}

OverlapGraph without_opposed(const OverlapGraph& graph, const std::vector<Vec3>& outer_normals) {
  OverlapGraph kept;
  kept.offset.reserve(graph.offset.size());
  kept.links.reserve(graph.links.size());
  for (Index i = 0; i < outer_normals.size(); ++i) {
    for (const OverlapGraph::Link& link : graph[i])
      if (outer_normals[i].dot(outer_normals[link.to]) >= opposed) kept.links.push_back(link);
    kept.offset.push_back(kept.links.size());
  }
  return kept;
}

}  // namespace gpsrecon
