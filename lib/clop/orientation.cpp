// Propagation along a minimum spanning forest: Hoppe et al. 1992, by the algorithm of Kruskal 1956.

#include <gpsrecon/clop/orientation.h>
#include <gpsrecon/core/disjoint_sets.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr double most_remote = 3;    // in medians, of points whose normals tell the outer side
constexpr double cap_height = 0.02;  // of the extent, over which their weight falls by e
constexpr double clear_majority = 0.5;

void check_lengths(std::size_t normals, std::size_t others, const std::string& what) {
  if (normals != others)
    throw InvariantError("orientation: " + std::to_string(normals) + " normals for " + std::to_string(others) + " " +
                         what);
}

/// Of two linked points, a < b.
struct Link {
  Index a, b;
  float cost;
  bool agree;  ///< whether their normals are on the same side of the surface as they are

  friend bool operator<(const Link& x, const Link& y) {
    if (x.cost != y.cost) return x.cost < y.cost;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  }
};

Link link_of(Index a, Index b, std::span<const Vec3> positions, const std::vector<Vec3>& normals) {
  const Vec3 between = positions[b] - positions[a];
  const double length = between.norm();
  const Vec3 direction = length > 0 ? Vec3(between / length) : Vec3(Vec3::Zero());
  const double along_a = direction.dot(normals[a]), along_b = direction.dot(normals[b]);
  // n_a · (n_b mirrored at the plane between the points): on a circular arc the mirror takes one normal to the other.
  const double cosine = normals[a].dot(normals[b]) - 2 * along_a * along_b;
  const double cost = 1 - std::abs(cosine) + 0.5 * (along_a * along_a + along_b * along_b);
  return {a, b, static_cast<float>(cost), cosine >= 0};
}

/// Links of every point with its nearest ones, cheapest first, and the distance of the farthest of them.
std::vector<Link> neighbor_links(std::span<const Vec3> positions, const std::vector<Vec3>& normals, std::size_t k,
                                 std::vector<double>& remoteness, const RunContext& context) {
  const std::size_t n = positions.size();
  remoteness.resize(n);
  const Neighbors index(positions);
  std::vector<std::vector<Link>> blocks((n + parallel_block_size - 1) / parallel_block_size);
  parallel_blocks(n, context, [&](std::size_t block, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> near;
    std::vector<Link>& links = blocks[block];
    links.reserve((end - begin) * k);
    for (std::size_t i = begin; i < end; ++i) {
      index.nearest(positions[i], k + 1, near);
      remoteness[i] = near.back().distance;
      for (const Neighbor& neighbor : near) {
        const auto [a, b] = std::minmax({static_cast<Index>(i), neighbor.index});
        if (a != b) links.push_back(link_of(a, b, positions, normals));
      }
    }
    std::sort(links.begin(), links.end());
  });
  std::vector<Link> all;
  all.reserve(n * k);
  for (std::vector<Link>& links : blocks) {
    all.insert(all.end(), links.begin(), links.end());
    links = {};
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// Numbers of the components of the points, in order of first appearance.
struct Parts {
  std::vector<Index> of_point;
  std::size_t count = 0;
};

Parts turn_to_roots(std::vector<Vec3>& normals, DisjointSets& forest) {
  Parts parts{std::vector<Index>(normals.size()), 0};
  std::vector<Index> number(normals.size(), no_index);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const auto [root, sign] = forest.root(static_cast<Index>(i));
    if (number[root] == no_index) number[root] = static_cast<Index>(parts.count++);
    parts.of_point[i] = number[root];
    if (sign < 0) normals[i] = -normals[i];
  }
  return parts;
}

/// The points of every part that are not far from their neighbours, as outliers are, whose normals mean nothing.
std::vector<std::vector<Index>> settled_points(const Parts& parts, const std::vector<double>& remoteness) {
  std::vector<std::vector<Index>> settled(parts.count);
  for (std::size_t i = 0; i < remoteness.size(); ++i) settled[parts.of_point[i]].push_back(static_cast<Index>(i));
  std::vector<double> distances;
  for (std::vector<Index>& points : settled) {
    distances.clear();
    for (const Index i : points) distances.push_back(remoteness[i]);
    const double limit = most_remote * median(distances);
    std::erase_if(points, [&](Index i) { return remoteness[i] > limit; });
  }
  return settled;
}

/// How far the normals at the extreme of the points in a direction point that way, and how far either way. Not only the
/// outermost point counts but all of the cap below it, the less the lower, so that no single normal decides.
struct CapVote {
  double outward = 0, either = 0;
};

CapVote vote_of_cap(std::span<const Vec3> positions, const std::vector<Vec3>& normals, const std::vector<Index>& points,
                    const Vec3& direction) {
  const Vec3& origin = positions[points.front()];
  double top = 0, bottom = 0;
  for (const Index i : points) {
    const double height = direction.dot(positions[i] - origin);
    top = std::max(top, height);
    bottom = std::min(bottom, height);
  }
  const double cap = cap_height * (top - bottom);
  CapVote vote;
  for (const Index i : points) {
    const double depth = top - direction.dot(positions[i] - origin);
    if (depth > 16 * cap) continue;
    const double term = (depth > 0 ? std::exp(-depth / cap) : 1.0) * direction.dot(normals[i]);
    vote.outward += term;
    vote.either += std::abs(term);
  }
  return vote;
}

/// Negative if the normals of a component point inward. Those of a closed surface say so in all directions; where they
/// contradict each other there is no outside, and the upper side is as good as any.
double outwardness(std::span<const Vec3> positions, const std::vector<Vec3>& normals,
                   const std::vector<Index>& points) {
  CapVote all;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const CapVote vote = vote_of_cap(positions, normals, points, Vec3(x, y, z).normalized());
        all.outward += vote.outward;
        all.either += vote.either;
      }
  if (std::abs(all.outward) >= clear_majority * all.either) return all.outward;
  return vote_of_cap(positions, normals, points, Vec3::UnitZ()).outward;
}

}  // namespace

void orient_along(std::vector<Vec3>& normals, std::span<const Vec3> directions) {
  check_lengths(normals.size(), directions.size(), "directions");
  for (std::size_t i = 0; i < normals.size(); ++i)
    if (normals[i].dot(directions[i]) < 0) normals[i] = -normals[i];
}

std::size_t orient_by_propagation(std::vector<Vec3>& normals, std::span<const Vec3> positions,
                                  const PropagationOptions& options, const RunContext& context) {
  options.check();
  check_lengths(normals.size(), positions.size(), "positions");
  if (positions.empty()) return 0;
  DisjointSets forest(positions.size());
  std::vector<double> remoteness;
  // The links that join something, in this order, are those of a minimum spanning forest (Kruskal 1956).
  for (const Link& link :
       neighbor_links(positions, normals, static_cast<std::size_t>(options.neighbors), remoteness, context))
    forest.join(link.a, link.b, link.agree ? 1 : -1);
  context.progress("orientation", 0.9);
  const Parts parts = turn_to_roots(normals, forest);
  const std::vector<std::vector<Index>> settled = settled_points(parts, remoteness);
  std::vector<double> outward(parts.count);
  parallel_for(
      parts.count, context, [&](std::size_t p) { outward[p] = outwardness(positions, normals, settled[p]); }, 1);
  for (std::size_t i = 0; i < normals.size(); ++i)
    if (outward[parts.of_point[i]] < 0) normals[i] = -normals[i];
  context.progress("orientation", 1);
  return parts.count;
}

}  // namespace gpsrecon
