#include "repair.h"

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/repair_topology.h>

namespace gpsrecon::cli {
namespace {

void tell(const TopologyRepair& repair, const std::string& path, const Console& console) {
  console.warn(path + ": repaired: " + std::to_string(repair.cut_edges) + " edges of more than two faces cut, " +
               std::to_string(repair.torn_edges) + " edges torn where there is one side only, " +
               std::to_string(repair.turned_faces) + " faces turned, " + std::to_string(repair.copies) +
               " vertices copied, " + std::to_string(repair.dropped_faces) + " faces dropped");
}

}  // namespace

Mesh repaired(const Mesh& mesh, const std::string& path, const Console& console) {
  TopologyRepair repair = repair_topology(mesh.faces, mesh.positions.size());
  if (!repair.changed()) return mesh;
  tell(repair, path, console);
  PointCloud vertices;
  vertices.positions = mesh.positions;
  vertices.colors = mesh.colors;
  vertices.scalars = mesh.scalars;
  vertices = select(vertices, repair.origin);
  Mesh result;
  result.positions = std::move(vertices.positions);
  result.colors = std::move(vertices.colors);
  result.scalars = std::move(vertices.scalars);
  result.frame = mesh.frame;
  result.faces = std::move(repair.faces);
  return result;
}

CovMesh repaired(const CovMesh& mesh, const std::string& path, const Console& console) {
  TopologyRepair repair = repair_topology(mesh.faces, mesh.vertices.size());
  if (!repair.changed()) return mesh;
  tell(repair, path, console);
  CovMesh result;
  result.rules = mesh.rules;
  result.vertices = select(mesh.vertices, repair.origin);
  result.faces = std::move(repair.faces);
  std::vector<double> shares(mesh.vertices.size(), 0);
  for (const Index v : repair.origin) ++shares[v];
  for (std::size_t v = 0; v < repair.origin.size(); ++v) result.vertices.weights[v] /= shares[repair.origin[v]];
  return result;
}

}  // namespace gpsrecon::cli
