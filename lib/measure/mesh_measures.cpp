// Volume by the divergence theorem, genus by the Euler characteristic.

#include <gpsrecon/measure/mesh_measures.h>

#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/self_intersections.h>
#include <Eigen/Geometry>
#include <algorithm>

namespace gpsrecon {

using namespace internal;

bool is_closed(const Topology& t) {
  return t.faces > 0 && t.boundary_edges == 0 && t.manifold();
}

std::optional<long> genus(const Topology& t) {
  if (!is_closed(t)) return std::nullopt;
  return (2 * static_cast<long>(t.components) - t.euler) / 2;
}

double surface_area(const std::vector<Vec3>& positions, const FaceList& faces, const RunContext& context) {
  return parallel_sum<double>(faces.size(), context, [&](std::size_t f) {
    double area = 0;
    for_each_triangle(faces[f], [&](Index a, Index b, Index c) {
      area += area_vector(positions[a], positions[b], positions[c]).norm() / 2;
    });
    return area;
  });
}

double enclosed_volume(const std::vector<Vec3>& positions, const FaceList& faces, const RunContext& context) {
  if (faces.corners.empty()) return 0;
  // Cones from a point of the surface itself: nothing is lost far from the origin.
  const Vec3 apex = positions[faces.corners[0]];
  return parallel_sum<double>(faces.size(), context, [&](std::size_t f) {
    double volume = 0;
    for_each_triangle(faces[f], [&](Index i, Index j, Index k) {
      const Vec3 a = positions[i] - apex, b = positions[j] - apex, c = positions[k] - apex;
      volume += a.dot(b.cross(c)) / 6;
    });
    return volume;
  });
}

MeshMeasures measure_mesh(const Mesh& mesh, const RunContext& context, bool self_intersections) {
  const double scale = mesh.frame.scale();
  MeshMeasures report;
  report.vertices = mesh.positions.size();
  report.faces = mesh.faces.size();
  report.topology = topology(mesh.faces, mesh.positions.size());
  report.area = surface_area(mesh.positions, mesh.faces, context) * scale * scale;
  if (is_closed(report.topology))
    report.volume = enclosed_volume(mesh.positions, mesh.faces, context) * scale * scale * scale;
  if (self_intersections)
    report.self_intersecting_faces = self_intersecting_faces(mesh.positions, mesh.faces, context).size();
  return report;
}

std::vector<BoundaryLoop> measure_boundary_loops(const std::vector<Vec3>& positions, const Connectivity& connectivity,
                                                 const Frame& frame, const std::vector<std::string>& reasons) {
  std::vector<BoundaryLoop> loops;
  for (const std::vector<Index>& vertices : boundary_loops(connectivity)) {
    BoundaryLoop loop;
    if (!reasons.empty()) loop.reason = reasons[loops.size()];
    loop.vertex = *std::min_element(vertices.begin(), vertices.end());
    loop.edges = vertices.size();
    Vec3 weighted = Vec3::Zero(), plain = Vec3::Zero();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec3 &a = positions[vertices[i]], &b = positions[vertices[(i + 1) % vertices.size()]];
      const double length = (b - a).norm();
      loop.length += length;
      weighted += length * (a + b) / 2;
      plain += a;
    }
    const Vec3 center =
        loop.length > 0 ? Vec3(weighted / loop.length) : Vec3(plain / static_cast<double>(vertices.size()));
    loop.center = frame.to_world(center);
    loop.length *= frame.scale();
    loops.push_back(std::move(loop));
  }
  std::stable_sort(loops.begin(), loops.end(),
                   [](const BoundaryLoop& a, const BoundaryLoop& b) { return a.length > b.length; });
  return loops;
}

Compression compression(const CovMesh& mesh, std::size_t points_read) {
  Compression report;
  report.numbers_read = 3 * points_read;
  report.numbers_stored = 10 * mesh.vertices.size() + mesh.faces.corners.size();
  if (points_read > 0)
    report.ratio = static_cast<double>(report.numbers_stored) / static_cast<double>(report.numbers_read);
  return report;
}

}  // namespace gpsrecon
