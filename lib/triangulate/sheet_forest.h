#pragma once

#include <gpsrecon/triangulate/overlap_graph.h>
#include <span>
#include <vector>

namespace gpsrecon::internal {

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

}  // namespace gpsrecon::internal
