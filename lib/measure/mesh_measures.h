#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/run_context.h>
#include <optional>
#include <string>
#include <vector>

namespace gpsrecon {

/// A polygon mesh as it is. Areas and volumes in scene units.
struct MeshMeasures {
  std::size_t vertices = 0, faces = 0;
  Topology topology;
  double area = 0;
  std::optional<double> volume;                        ///< enclosed, positive if faces point outward; only if closed
  std::optional<std::size_t> self_intersecting_faces;  ///< if they were counted
};

/// A boundary of a surface.
struct BoundaryLoop {
  std::size_t edges = 0;
  double length = 0;
  Vec3 center = Vec3::Zero();      ///< mean of its edges' middles by length
  std::string reason = "unknown";  ///< why it is open, the name of a LoopReason (triangulate/triangulate.h)
  Index vertex = no_index;         ///< the first of its vertices: tells which loop it is; not written
};

/// Numbers stored in the covariance mesh against numbers read, see compression().
struct Compression {
  std::size_t numbers_read = 0, numbers_stored = 0;
  double ratio = 0;  ///< stored / read
};

/// True if the surface has faces, no boundary, and is manifold and consistently oriented.
bool is_closed(const Topology& topology);

/// Number of handles, summed over the components; only for closed surfaces.
std::optional<long> genus(const Topology& topology);

/// Area of the faces (each a fan of triangles from its first corner), in squared units of the positions.
double surface_area(const std::vector<Vec3>& positions, const FaceList& faces, const RunContext& context = {});

/// Volume enclosed by closed, consistently oriented faces, positive if they point outward, in cubed units of the
/// positions.
double enclosed_volume(const std::vector<Vec3>& positions, const FaceList& faces, const RunContext& context = {});

/// Counts, topology, area and, if closed, volume, in scene units, and on request the self-intersecting faces
/// (self_intersections.h). O(c log c) in the corners. Throws InvariantError if a corner is out of range.
MeshMeasures measure_mesh(const Mesh& mesh, const RunContext& context = {}, bool self_intersections = false);

/// The boundary loops of a mesh, longest first, in scene units and world coordinates. `reasons` are those of the loops
/// in the order of boundary_loops(), or empty if unknown.
std::vector<BoundaryLoop> measure_boundary_loops(const std::vector<Vec3>& positions, const Connectivity& connectivity,
                                                 const Frame& frame, const std::vector<std::string>& reasons = {});

/// Numbers stored: ten per vertex (mean 3, covariance 6, weight 1) and one per face corner (its index); numbers read:
/// three per point. A plain triangle mesh would store three per vertex: the covariances cost six numbers more, and the
/// weight one.
Compression compression(const CovMesh& mesh, std::size_t points_read);

}  // namespace gpsrecon
