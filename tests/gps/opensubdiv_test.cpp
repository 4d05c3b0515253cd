// OpenSubdiv as a second implementation of refinement, limit positions and tangent planes.

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/loop.h>
#include <gpsrecon/gps/subdivide.h>
#include <gtest/gtest.h>

#include <opensubdiv/far/primvarRefiner.h>

#include "opensubdiv.h"
#include "support/covmeshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

constexpr int levels = 2;

/// The vertices of a level by OpenSubdiv.
struct Level {
  std::vector<Vec3> refined, limit, normals;
  std::vector<bool> comparable;  ///< whether its tangents are those of the rules it refines with
};

Level opensubdiv_level(const Mesh& mesh, const SurfaceRules& rules) {
  const std::unique_ptr<Far::TopologyRefiner> refiner = osd_refiner(mesh, rules);
  Far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);
  const Far::PrimvarRefinerReal<double> values(*refiner);
  std::vector<OsdPoint> points = osd_points(mesh);
  for (int level = 1; level <= levels; ++level) {
    std::vector<OsdPoint> fine(static_cast<std::size_t>(refiner->GetLevel(level).GetNumVertices()));
    values.Interpolate(level, points, fine);
    points.swap(fine);
  }
  std::vector<OsdPoint> limit(points.size()), u(points.size()), v(points.size());
  values.Limit(points, limit, u, v);
  Level level;
  const Far::TopologyLevel& last = refiner->GetLevel(levels);
  for (std::size_t i = 0; i < points.size(); ++i) {
    level.refined.push_back(points[i].p);
    level.limit.push_back(limit[i].p);
    level.normals.push_back(u[i].p.cross(v[i].p).normalized());
    // On the boundary it takes the tangents of rules that depend on the number of faces; those are not the rules it
    // refines with unless that number is at most that of a regular vertex.
    const auto at = static_cast<Far::Index>(i);
    const int regular = rules.scheme == Scheme::loop ? 3 : 2;
    const int faces = last.GetVertexFaces(at).size();
    level.comparable.push_back(faces > 0 && (!last.IsVertexBoundary(at) || faces <= regular));
  }
  return level;
}

/// Vertices are numbered differently: those of one are matched with the nearest of the other, one to one.
void expect_agreement(const Mesh& mesh, const SurfaceRules& rules) {
  const CovMesh control = with_rules(with_equal_covariances(mesh, Random(5).covariance(0.1, 1)), rules);
  SubdivideOptions refine{.levels = levels, .limit = false};
  const Mesh refined = subdivide(control, refine);
  refine.limit = true;
  const Mesh limit = subdivide(control, refine);
  const Level theirs = opensubdiv_level(mesh, rules);
  ASSERT_EQ(refined.positions.size(), theirs.refined.size());
  const Neighbors index(theirs.refined);
  std::vector<bool> hit(theirs.refined.size(), false);
  std::vector<Neighbor> nearest;
  std::size_t compared = 0;
  for (std::size_t v = 0; v < refined.positions.size(); ++v) {
    index.nearest(refined.positions[v], 1, nearest);
    const std::size_t other = nearest[0].index;
    ASSERT_LT(nearest[0].distance, 1e-13) << "vertex " << v;
    EXPECT_FALSE(hit[other]) << "vertex " << v;
    hit[other] = true;
    EXPECT_LT((limit.positions[v] - theirs.limit[other]).norm(), 1e-13) << "vertex " << v;
    if (!theirs.comparable[other]) continue;
    ++compared;
    EXPECT_LT((limit.normals[v] - theirs.normals[other]).norm(), 1e-10) << "vertex " << v;
  }
  EXPECT_GT(compared, refined.positions.size() / 2);
}

TEST(OpenSubdivLoop, AgreesOnClosedMeshes) {
  for (const Mesh& mesh : {tetrahedron(), octahedron(), torus(9, 6)}) expect_agreement(mesh, {});
  for (const std::uint64_t seed : {1, 2, 3}) expect_agreement(irregular_sphere(seed), {});
}

TEST(OpenSubdivLoop, AgreesOnBoundaries) {
  Mesh patch = grid(5, 4);
  Random random(6);
  for (Vec3& p : patch.positions) p += 0.3 * random.vector();
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp})
    expect_agreement(patch, {.corners = corners});
}

TEST(OpenSubdivCatmullClark, AgreesOnEveryShape) {
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp})
    for (const auto& [name, mesh] : polygon_shapes()) {
      SCOPED_TRACE(name);
      expect_agreement(mesh, {.scheme = Scheme::catmull_clark, .corners = corners});
    }
}

}  // namespace
}  // namespace gpsrecon::test
