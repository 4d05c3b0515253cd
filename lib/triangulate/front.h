#pragma once

#include <gpsrecon/core/run_context.h>
#include <gpsrecon/triangulate/growing_surface.h>
#include <gpsrecon/triangulate/overlap_graph.h>
#include <gpsrecon/triangulate/triangulate.h>
#include <optional>

namespace gpsrecon {

/// Judges triangles against the surface so far; shared by the front and the repair.
class TriangleJudge {
 public:
  /// Without `forbid_overlap` triangles may overlap others around their vertices in projection.
  TriangleJudge(const OverlapGraph& graph, const GrowingSurface& surface, double min_dihedral,
                bool forbid_overlap = true)
      : graph_(graph), surface_(surface), min_dihedral_(min_dihedral), forbid_overlap_(forbid_overlap) {}

  /// ln(BC_ab BC_bc BC_ca), Preiner et al. 2019, Eq. 20; nullopt if a pair overlaps too little.
  std::optional<double> log_overlap(Index a, Index b, Index c) const;

  /// Smallest dihedral angle of triangle abc (counter-clockwise) to its neighbours across edges, π without any;
  /// nullopt if it may not be added: a half-edge is taken, a vertex has no room, a fan would close beside another, an
  /// angle is too sharp, or (if forbidden) it overlaps triangles around its vertices.
  std::optional<double> dihedral(Index a, Index b, Index c) const;

  /// The triangle lies over or under triangles near it that share no vertex with it. Dearer than dihedral().
  bool crosses(Index a, Index b, Index c) const;

 private:
  bool keeps_fans(Index v, Index next, Index previous) const;
  bool overlaps_fan(Index v, const GrowingSurface::Triangle& triangle, const Vec3& normal) const;

  const OverlapGraph& graph_;
  const GrowingSurface& surface_;
  double min_dihedral_;
  bool forbid_overlap_;
};

/// Grows the surface over the graph from the most plausible seed triangles, always by the most plausible triangle at
/// any edge of the front, until no triangle can be added.
void grow_front(GrowingSurface& surface, const OverlapGraph& graph, const TriangulateOptions& options,
                const RunContext& context);

}  // namespace gpsrecon
