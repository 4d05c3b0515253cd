#pragma once

#include <gpsrecon/core/clean.h>
#include <gpsrecon/fit/fit.h>
#include <gpsrecon/gps/subdivide.h>
#include <gpsrecon/hem/hem.h>
#include <gpsrecon/hem/scale.h>
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
  double detail = 1;
  std::size_t budget = 0;
  std::optional<Length> max_error;
  bool check_scale = false;
  bool self_intersections = false;

  static OptionTable fields() {
    using O = ReconstructOptions;
    return {
        field<&O::detail>(
            "detail", "(0, 100]",
            "divide the automatic kernel width by X: above 1 more detail, below 1 smoother; clamped, with a "
            "warning, where the surface would fall apart"),
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

/// The points the stages work on, and the scale found in them.
struct PreparedCloud {
  CleanCloud clean;  ///< without the isolated points
  Scale scale;       ///< in local units; `isolated` refers to the points before they were dropped
  std::size_t isolated = 0;
  double diagonal = 0;  ///< bounding-box diagonal of the remaining points, local units

  /// What options that are lengths refer to.
  LengthScale lengths() const;
};

/// Cleans the cloud (core/clean.h), estimates its scale (hem/scale.h) and drops isolated points.
/// Throws InputError if no point is finite; NoSurfaceError if the rest is one or two points, equal or on a line.
PreparedCloud prepare(const PointCloud& world, const ScaleOptions& options = {}, const RunContext& context = {});

struct Reconstruction {
  CovMesh covmesh;
  Mesh mesh;
  ErrorReport report;
};

/// The stages one by one, as the chain and the commands of the program run them. Results of stages that are written to
/// files are rounded so that the file gives back the same bits.
Mixture mixture_stage(const PreparedCloud& cloud, const ReconstructOptions& options, const RunContext& context,
                      ErrorReport& report);
CovMesh triangulate_stage(const Mixture& mixture, const ReconstructOptions& options, const RunContext& context,
                          ErrorReport& report);
/// Also turns open components to where the points were seen from, or to the side of their normals, if they tell.
CovMesh fit_stage(CovMesh mesh, const PreparedCloud& cloud, const ReconstructOptions& options,
                  const RunContext& context, ErrorReport& report);
Mesh subdivide_stage(const CovMesh& mesh, const ReconstructOptions& options, const RunContext& context,
                     ErrorReport& report);
/// With the points at hand, their colours and scalars (core/attributes.h) instead of the coarser ones of the Gaussians.
Mesh subdivide_stage(const CovMesh& mesh, const PreparedCloud& cloud, const ReconstructOptions& options,
                     const RunContext& context, ErrorReport& report);

/// Points to surface: clean, scale, mixture, triangulation, fit, subdivision, report. The input is in world
/// coordinates. Throws what the stages throw.
Reconstruction reconstruct(const PointCloud& world, const ReconstructOptions& options = {},
                           const RunContext& context = {});

/// The flow from a mixture or a covariance mesh on; without points there is no fit and no distance in the report, and
/// `budget`, `max_error` and `check_scale` are refused.
Reconstruction reconstruct(const Mixture& mixture, const ReconstructOptions& options = {},
                           const RunContext& context = {});
Reconstruction reconstruct(const CovMesh& mesh, const ReconstructOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
