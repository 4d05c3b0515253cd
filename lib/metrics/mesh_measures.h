#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/metrics/report.h>
#include <optional>
#include <vector>

namespace gpsrecon {

/// True if the surface has faces, no boundary, and is manifold and consistently oriented.
bool is_closed(const Topology& topology);

/// Number of handles, summed over the components; only for closed surfaces.
std::optional<long> genus(const Topology& topology);

/// Vector area of a face (a fan of triangles from its first corner), twice: its direction is the normal.
Vec3 area_vector(const Mesh& mesh, Index face);

/// Area of the faces (each a fan of triangles from its first corner), in squared units of the positions.
double surface_area(const std::vector<Vec3>& positions, const FaceList& faces, const RunContext& context = {});

/// Volume enclosed by closed, consistently oriented faces, positive if they point outward, in cubed units of the
/// positions.
double enclosed_volume(const std::vector<Vec3>& positions, const FaceList& faces, const RunContext& context = {});

/// Counts, topology, area and, if closed, volume, in scene units, and on request the self-intersecting faces
/// (self_intersections.h). O(c log c) in the corners. Throws InvariantError if a corner is out of range.
MeshReport measure_mesh(const Mesh& mesh, const RunContext& context = {}, bool self_intersections = false);

/// The boundary loops of a mesh, longest first, in scene units and world coordinates. `reasons` are those of the loops
/// in the order of boundary_loops(), or empty if unknown.
std::vector<BoundaryLoop> measure_boundary_loops(const std::vector<Vec3>& positions, const FaceList& faces,
                                                 const Frame& frame, const std::vector<std::string>& reasons = {});

/// Numbers stored: ten per vertex (mean 3, covariance 6, weight 1) and one per face corner (its index); numbers read:
/// three per point. A plain triangle mesh would store three per vertex: the covariances cost six numbers more, and the
/// weight one.
CompressionReport compression(const CovMesh& mesh, std::size_t points_read);

}  // namespace gpsrecon
