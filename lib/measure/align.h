#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>

namespace gpsrecon {

/// The rigid motion by which a shape was brought onto the reference before it was compared: x becomes
/// rotation x + translation, in world coordinates.
struct Alignment {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  int iterations = 0;
  bool converged = false;
  double rms_before = 0, rms_after = 0;  ///< distance of the points that were matched, scene units
};

struct AlignOptions {
  int iterations = 100;
  std::size_t samples = 20000;
  double trim = 4;
  double convergence = 1e-9;

  static OptionTable fields() {
    using O = AlignOptions;
    return {
        field<&O::iterations>("align-iterations", "[1, 10000]", "steps, at most"),
        field<&O::samples>(
            "align-samples", "[10, 1e7]",
            "points of the moving shape that are matched: samples uniform by area, or points of the cloud at random"),
        field<&O::trim>("align-trim", "> 1",
                        "points farther than X median distances have no part in a step: what has no counterpart must "
                        "not pull"),
        field<&O::convergence>("align-convergence", ">= 0",
                               "end when a step moves no point farther than this share of the diagonal of the "
                               "reference")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// The rigid motion that brings a shape onto a reference from where it is: iterative closest points (Besl and McKay
/// 1992), towards meshes by the distance from the tangent plane (Chen and Medioni 1992), towards clouds from point to
/// point. It finds the nearest minimum, so the shape has to lie about right: rotated by less than some 20 degrees, and
/// shifted by less than the size of what tells it from its surroundings. World coordinates: x becomes rotation x +
/// translation. O(iterations · samples log n). Throws OptionError; InvariantError if a shape is empty.
Alignment align(const Mesh& shape, const Mesh& reference, const AlignOptions& options = {},
                const RunContext& context = {});
Alignment align(const Mesh& shape, const PointCloud& reference, const AlignOptions& options = {},
                const RunContext& context = {});
Alignment align(const PointCloud& shape, const Mesh& reference, const AlignOptions& options = {},
                const RunContext& context = {});
Alignment align(const PointCloud& shape, const PointCloud& reference, const AlignOptions& options = {},
                const RunContext& context = {});

/// The shape after the motion, in its own frame.
Mesh moved_by(const Mesh& mesh, const Alignment& motion);
PointCloud moved_by(const PointCloud& cloud, const Alignment& motion);

}  // namespace gpsrecon
