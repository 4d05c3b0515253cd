#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>

namespace gpsrecon {

struct FitOptions {
  /// Averaging steps. Range: [0, 100]; 0 = return the mesh as it is.
  int steps = 5;
  /// Refinement level at which the surface is sampled. Range: [0, 5].
  int level = 2;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// Moves the means of a triangular covariance mesh along the normals so that its limit surface runs through the points:
/// each point is assigned to the closest surface sample, and each vertex moves by the robust (biweight) average of
/// the signed normal offsets in its support. Vertices of the rim of an open surface also move outward, to where the
/// points end (if `mesh.vertices.spacing` is known). Covariances and faces stay. Mesh and cloud must be in the same
/// frame. O(n log m) per step for n points and m samples. Throws OptionError, InvariantError, Cancelled.
CovMesh fit(CovMesh mesh, const PointCloud& cloud, const FitOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
