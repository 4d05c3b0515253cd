// OpenSubdiv as a second implementation of Loop refinement, limit positions and tangent planes.

#include <gpsrecon/gps/limit_surface.h>
#include <gtest/gtest.h>

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <memory>

#include "meshes.h"

namespace gpsrecon::test {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

/// A point with the interface OpenSubdiv asks of vertex values.
struct Value {
  Vec3 p = Vec3::Zero();
  void Clear() { p.setZero(); }
  void AddWithWeight(const Value& other, double weight) { p += weight * other.p; }
};

struct LimitPoints {
  std::vector<Vec3> positions, normals;
};

/// Limit points at the control vertices.
LimitPoints opensubdiv_limit(const Mesh& mesh, CornerRule corners) {
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(corners == CornerRule::smooth ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                                                    : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
  const std::vector<int> sizes(mesh.faces.size(), 3);
  const std::vector<int> indices(mesh.faces.corners.begin(), mesh.faces.corners.end());
  Far::TopologyDescriptor description;
  description.numVertices = static_cast<int>(mesh.positions.size());
  description.numFaces = static_cast<int>(mesh.faces.size());
  description.numVertsPerFace = sizes.data();
  description.vertIndicesPerFace = indices.data();
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(description, Factory::Options(Sdc::SCHEME_LOOP, options)));
  Far::TopologyRefiner::UniformOptions uniform(1);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);

  std::vector<Value> control(mesh.positions.size());
  for (std::size_t v = 0; v < control.size(); ++v) control[v].p = mesh.positions[v];
  const auto fine_count = static_cast<std::size_t>(refiner->GetLevel(1).GetNumVertices());
  std::vector<Value> fine(fine_count), limit(fine_count), u(fine_count), v(fine_count);
  const Far::PrimvarRefinerReal<double> values(*refiner);
  values.Interpolate(1, control, fine);
  values.Limit(fine, limit, u, v);

  LimitPoints points;
  for (int i = 0; i < description.numVertices; ++i) {
    const auto child = static_cast<std::size_t>(refiner->GetLevel(0).GetVertexChildVertex(i));
    points.positions.push_back(limit[child].p);
    points.normals.push_back(u[child].p.cross(v[child].p).normalized());
  }
  return points;
}

void expect_agreement(const Mesh& mesh, CornerRule corners) {
  const CovMesh control = with_equal_covariances(mesh, RandomSequence(5).covariance(0.1, 1));
  const Mesh ours = subdivide(control, {.levels = 1, .corners = corners});
  const LimitPoints theirs = opensubdiv_limit(mesh, corners);
  const TriangleConnectivity topology = triangle_connectivity(mesh.faces, mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    SCOPED_TRACE(testing::Message() << "vertex " << v << " of " << topology.face_count[v] << " faces, "
                                    << (topology.on_boundary(static_cast<Index>(v)) ? "boundary" : "interior"));
    EXPECT_LT((ours.positions[v] - theirs.positions[v]).norm(), 1e-12);
    // On the boundary OpenSubdiv takes the tangents of rules that depend on the number of faces; those are not the
    // rules it refines with unless that number is at most three.
    if (topology.face_count[v] <= 3 || !topology.on_boundary(static_cast<Index>(v))) {
      EXPECT_LT((ours.normals[v] - theirs.normals[v]).norm(), 1e-10);
    }
  }
}

TEST(OpenSubdiv, AgreesOnClosedMeshes) {
  expect_agreement(tetrahedron(), CornerRule::smooth);
  expect_agreement(octahedron(), CornerRule::smooth);
  expect_agreement(torus(9, 6), CornerRule::smooth);
  for (const std::uint64_t seed : {1, 2, 3}) expect_agreement(irregular_sphere(seed), CornerRule::smooth);
}

TEST(OpenSubdiv, AgreesOnBoundaries) {
  Mesh patch = grid(5, 4);
  RandomSequence random(6);
  for (Vec3& p : patch.positions) p += 0.3 * random.vector();
  expect_agreement(patch, CornerRule::smooth);
  expect_agreement(patch, CornerRule::sharp);
}

}  // namespace
}  // namespace gpsrecon::test
