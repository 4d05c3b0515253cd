#pragma once

#include <gpsrecon/core/run_context.h>
#include <gpsrecon/triangulate/growing_surface.h>
#include <gpsrecon/triangulate/overlap_graph.h>
#include <gpsrecon/triangulate/triangulate.h>
#include <optional>

namespace gpsrecon::internal {

/// Per component the unit normal of the sheet it lies in, or zero where it is not flat, as on creases, tips and
/// outliers: without the kernel σ0² its smallest deviation is more than half the middle one.
std::vector<Vec3> sheet_normals(const Mixture& mixture, const RunContext& context);

/// What is known of the sheet that each component lies in.
struct Sheets {
  std::vector<Vec3> normals;  ///< sheet_normals(): of either sign, zero where not flat
  std::vector<Vec3> outer;    ///< outer_normals(): zero where unknown

  /// Of which the outer sides are not known.
  explicit Sheets(std::vector<Vec3> sheet_normals)
      : normals(std::move(sheet_normals)), outer(normals.size(), Vec3::Zero()) {}
};

/// Judges triangles against the surface so far; shared by the front and the repair.
class TriangleJudge {
 public:
  /// With `lenient` triangles may overlap others around their vertices in projection and turn their back on them.
  TriangleJudge(const OverlapGraph& graph, const Sheets& sheets, const GrowingSurface& surface, double min_dihedral,
                bool lenient = false)
      : graph_(graph), sheets_(sheets), surface_(surface), min_dihedral_(min_dihedral), lenient_(lenient) {}

  /// ln(BC_ab BC_bc BC_ca), Preiner et al. 2019, Eq. 20; nullopt if a pair overlaps too little.
  std::optional<double> log_overlap(Index a, Index b, Index c) const;

  /// Smallest dihedral angle of triangle abc (counter-clockwise) to its neighbours across edges, π without any;
  /// nullopt if it may not be added: a half-edge is taken, a vertex has no room, a fan would close beside another, an
  /// angle is too sharp, or (unless lenient) it overlaps triangles around its vertices or shows the other side of a
  /// sheet.
  std::optional<double> dihedral(Index a, Index b, Index c) const;

 private:
  bool keeps_fans(Index v, Index next, Index previous) const;
  bool turns_back(Index v, const Vec3& normal) const;
  bool overlaps_fan(Index v, const GrowingSurface::Triangle& triangle, const Vec3& normal) const;

  const OverlapGraph& graph_;
  const Sheets& sheets_;
  const GrowingSurface& surface_;
  double min_dihedral_;
  bool lenient_;
};

/// Grows the surface over the graph from the most plausible seed triangles, always by the most plausible triangle at
/// any edge of the front, until no triangle can be added.
void grow_front(GrowingSurface& surface, const OverlapGraph& graph, const Sheets& sheets,
                const TriangulateOptions& options, const RunContext& context);

}  // namespace gpsrecon::internal
