// How often a run builds the connectivity of a mesh. Not in the count: the one editable mesh, and what adaptive
// refinement (a tolerance) builds, one per level. The linker puts these functions before those of the library
// (--wrap, see CMakeLists.txt beside this file); calls within connectivity.cpp do not pass them, so each counts once.

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <gtest/gtest.h>

#include <atomic>

#include "support/shapes.h"

namespace {
std::atomic<int> builds = 0;
}  // namespace

using gpsrecon::Connectivity;
using gpsrecon::CovMesh;
using gpsrecon::FaceList;

Connectivity real_build(const FaceList&, std::size_t) asm("__real_" GPSRECON_BUILD_CONNECTIVITY);
Connectivity real_manifold(const FaceList&, std::size_t, const char*) asm("__real_" GPSRECON_MANIFOLD_CONNECTIVITY);
Connectivity real_validated(const CovMesh&) asm("__real_" GPSRECON_VALIDATED_CONNECTIVITY);
Connectivity counted_build(const FaceList&, std::size_t) asm("__wrap_" GPSRECON_BUILD_CONNECTIVITY);
Connectivity counted_manifold(const FaceList&, std::size_t, const char*) asm("__wrap_" GPSRECON_MANIFOLD_CONNECTIVITY);
Connectivity counted_validated(const CovMesh&) asm("__wrap_" GPSRECON_VALIDATED_CONNECTIVITY);

Connectivity counted_build(const FaceList& faces, std::size_t vertex_count) {
  ++builds;
  return real_build(faces, vertex_count);
}
Connectivity counted_manifold(const FaceList& faces, std::size_t vertex_count, const char* what) {
  ++builds;
  return real_manifold(faces, vertex_count, what);
}
Connectivity counted_validated(const CovMesh& mesh) {
  ++builds;
  return real_validated(mesh);
}

namespace gpsrecon::test {
namespace {

TEST(ConnectivityCount, OfARunIsAtMostEight) {
  const PointCloud cloud = noisy_sphere(4000, 0.01);
  ReconstructOptions polygons, counted;
  polygons.triangulate.rules.scheme = Scheme::catmull_clark;
  counted.self_intersections = true;
  for (const ReconstructOptions& options : {ReconstructOptions(), polygons, counted}) {
    builds = 0;
    reconstruct(cloud, options);
    EXPECT_LE(builds, 8);
    EXPECT_GE(builds, 5);  // fewer, and not all were counted
  }
}

}  // namespace
}  // namespace gpsrecon::test
