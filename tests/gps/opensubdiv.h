#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/gps/evaluate.h>

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <memory>
#include <vector>

namespace gpsrecon::test {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

/// A point with the interface OpenSubdiv asks of vertex values.
struct OsdPoint {
  Vec3 p = Vec3::Zero();
  void Clear() { p.setZero(); }
  void AddWithWeight(const OsdPoint& other, double weight) { p += weight * other.p; }
};

inline std::vector<OsdPoint> osd_points(const Mesh& mesh) {
  std::vector<OsdPoint> points(mesh.positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) points[v].p = mesh.positions[v];
  return points;
}

/// OpenSubdiv's connectivity of a mesh, not yet refined.
inline std::unique_ptr<Far::TopologyRefiner> osd_refiner(const Mesh& mesh, const SurfaceRules& options) {
  Sdc::Options rules;
  rules.SetVtxBoundaryInterpolation(options.corners == CornerRule::smooth ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                                                          : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
  std::vector<int> sizes;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) sizes.push_back(static_cast<int>(mesh.faces[f].size()));
  const std::vector<int> indices(mesh.faces.corners.begin(), mesh.faces.corners.end());
  Far::TopologyDescriptor description;
  description.numVertices = static_cast<int>(mesh.positions.size());
  description.numFaces = static_cast<int>(mesh.faces.size());
  description.numVertsPerFace = sizes.data();
  description.vertIndicesPerFace = indices.data();
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const auto scheme = options.scheme == Scheme::loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK;
  return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(description, Factory::Options(scheme, rules)));
}

}  // namespace gpsrecon::test
