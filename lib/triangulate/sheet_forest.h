#pragma once

#include <gpsrecon/triangulate/overlap_graph.h>
#include <span>
#include <vector>

namespace gpsrecon {

/// Two Gaussians of one sheet, and how their normals relate.
struct SheetLink {
  double log_strength;  ///< ln of overlap times cosine
  Index a, b;
  int sign;  ///< 1 if their normals point to the same side, else -1
};

/// The pairs of the graph that lie in one sheet as far as their normals tell (at most 45° apart), strongest first:
/// joined in this order they form a maximum spanning forest, along which signs are passed on (Hoppe et al. 1992, over
/// Gaussians). Components with a zero normal are left out. O(n k log n).
std::vector<SheetLink> sheet_links(const OverlapGraph& graph, std::span<const Vec3> normals);

/// Disjoint sets of components, with a sign relative to each other within a set.
class SignedSets {
 public:
  explicit SignedSets(std::size_t n);

  struct Root {
    Index set;
    int sign;  ///< of the member relative to the root
  };
  Root find(Index v);
  /// Joins the sets of a and b so that these two have the given sign relative to each other. Precondition: they are in
  /// different sets. The root of a's stays.
  void join(Index a, Index b, int sign);

 private:
  std::vector<Index> parent_;
  std::vector<int> sign_;
};

}  // namespace gpsrecon
