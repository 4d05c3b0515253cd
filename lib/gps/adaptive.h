#pragma once

#include <gpsrecon/gps/evaluate.h>

// Internal to lib/gps: triangles that follow a limit surface as closely as wanted.

namespace gpsrecon::internal {

struct Tessellation {
  FaceList faces;  ///< triangles, as many components and boundary loops as the control mesh has
  std::vector<SurfaceParameter> parameters;  ///< per vertex; the control vertices come first, unused ones with no_index
  std::vector<Vec3> positions;               ///< on the limit surface; of unused vertices their mean
  std::size_t unresolved = 0;                ///< triangles that deviate by more but are too small to be split
};

/// Splits edges of the control mesh until no triangle is farther from the surface over it than `tolerance`, in units of
/// the control means. Edges are halved in the parameters of a patch, once for the faces on both sides, whose triangles
/// are cut along: there are no cracks and no T-junctions. An edge is halved where the surface along it is too far from
/// both triangles at it (at the boundary: from the edge), a triangle at its longest edge where the surface inside is;
/// and a triangle that is cut is cut at its longest edge in any case (Rivara 1984), which bounds its angles in the
/// parameters. Flat regions stay coarse. Distances are measured at 1/4, 1/2 and 3/4 of edges and four points inside,
/// twice as densely on control faces, and must stay within 0.7 of the tolerance. Edges are halved at most
/// `max_halvings` times.
/// Precondition: tolerance > 0. O(size of the result).
Tessellation tessellate(const SurfaceEvaluator& surface, const ConnectedMesh& control, double tolerance,
                        int max_halvings, const RunContext& context = {});

}  // namespace gpsrecon::internal
