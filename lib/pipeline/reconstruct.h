#pragma once

#include <gpsrecon/core/prepared_cloud.h>
#include <gpsrecon/fit/fit.h>
#include <gpsrecon/gps/subdivide.h>
#include <gpsrecon/hem/hem.h>
#include <gpsrecon/pipeline/projection.h>
#include <gpsrecon/report/report.h>
#include <gpsrecon/triangulate/triangulate.h>
#include <optional>

namespace gpsrecon {

/// Options of the whole flow: those of the stages, and what only makes sense across them.
struct ReconstructOptions {
  ScaleOptions scale;
  HemOptions hem;
  TriangulateOptions triangulate;
  FitOptions fit;
  SubdivideOptions subdivide;
  /// Makes the mixture of projected particles (projection.h) instead of the points, with the kernel width of the
  /// points. Surface and report still refer to the points. Excludes `max_error`. None: of the points.
  std::optional<ProjectionOptions> projection;
  std::size_t budget = 0;
  std::optional<Length> max_error;
  bool check_scale = false;
  bool self_intersections = false;

  static OptionTable fields() {
    using O = ReconstructOptions;
    return {
        field<&O::budget>("budget", ">= 4 or 0",
                          "vertices of the covariance mesh, at most, and about as many if it needs them: the kernel is "
                          "widened as far as it takes, and the fit adds vertices where the points show detail; 0 = no "
                          "limit"),
        field<&O::max_error>(
            "max-error", "> 0",
            "widen the kernel as far as the error of the surface, measured on points that are held out, "
            "stays within LENGTH; with a warning the automatic one stays if even that has a larger error"),
        field<&O::check_scale>(
            "check-scale", "",
            "compare kernel widths by the likelihood of points that are held out, for the report only"),
        field<&O::self_intersections>("self-intersections", "",
                                      "count the faces of covariance mesh and mesh that intersect others")};
  }
  /// Throws OptionError naming option, range and value, or two that contradict each other.
  void check() const;
};

/// A surface and what there is to say of it.
struct Reconstruction {
  CovMesh covmesh;     ///< in local coordinates: covmesh.vertices.frame.to_world() gives those of the input
  Mesh mesh;           ///< in the same frame
  ErrorReport report;  ///< lengths in scene units, positions in world coordinates, indices are rows of the input
};

/// Points to surface: clean, scale, mixture, triangulation, fit, subdivision, report. The input is in world
/// coordinates. `triangulate.sensor`, if given, is that of the points. Warnings and times are in the report, and in the
/// record of the context if it has one. Throws what the stages throw.
Reconstruction reconstruct(const PointCloud& world, const ReconstructOptions& options = {},
                           const RunContext& context = {});

/// The flow from a mixture or a covariance mesh on; without points there is no fit and no distance in the report, and
/// `budget`, `max_error` and `check_scale` are refused.
Reconstruction reconstruct(const Mixture& mixture, const ReconstructOptions& options = {},
                           const RunContext& context = {});
Reconstruction reconstruct(const CovMesh& mesh, const ReconstructOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
