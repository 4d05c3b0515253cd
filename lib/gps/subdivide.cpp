#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/gps/attributes.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/subdivide.h>
#include <cmath>

namespace gpsrecon {

void SubdivideOptions::check() const {
  if (levels < 0 || levels > 8) throw OptionError("levels: " + std::to_string(levels) + " is not in [0, 8]");
}

Mesh subdivide(const CovMesh& mesh, const SubdivideOptions& options, const RunContext& context) {
  options.check();
  context.progress("subdivide", 0);
  validate(mesh);
  LimitSurface surface(mesh.faces, mesh.vertices.size(), options.levels, options.weights, options.corners, context);
  context.progress("subdivide", 0.5);
  SurfaceSamples samples = surface.evaluate(mesh.vertices, options.limit, context);
  Mesh refined;
  refined.positions = std::move(samples.positions);
  refined.normals = std::move(samples.normals);
  refined.sigma = std::move(samples.sigma);
  if (options.attributes) interpolate_attributes(surface, mesh.vertices, refined, context);
  refined.faces = std::move(surface).faces();
  refined.frame = mesh.vertices.frame;
  context.progress("subdivide", 1);
  return refined;
}

int level_for_edge_length(const CovMesh& mesh, double target_edge, int max_level) {
  const HalfEdges topology = half_edges(mesh.faces, mesh.vertices.size());
  double sum = 0;
  std::size_t edges = 0;
  for (Index h = 0; h < topology.next.size(); ++h) {
    if (topology.opposite[h] != no_index && topology.opposite[h] < h) continue;
    sum +=
        (mesh.vertices.means[mesh.faces.corners[topology.next[h]]] - mesh.vertices.means[mesh.faces.corners[h]]).norm();
    ++edges;
  }
  if (edges == 0) return 0;
  // Every level halves the edges.
  double mean_edge = sum / static_cast<double>(edges);
  int level = 0;
  while (level < max_level && !(mean_edge <= target_edge)) {
    mean_edge /= 2;
    ++level;
  }
  return level;
}

}  // namespace gpsrecon
