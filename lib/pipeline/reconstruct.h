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
  HemOptions hem{.flat_levels = 4, .initial = InitialCovariance::local};
  TriangulateOptions triangulate;
  FitOptions fit;
  SubdivideOptions subdivide;
  /// Makes the mixture of projected particles (projection.h) instead of the points, with the kernel width of the
  /// points. Surface and report still refer to the points. Excludes `max_error_rel`. None: of the points.
  std::optional<ProjectionOptions> projection;
  /// Divides the automatic kernel width: above 1 more detail, below 1 smoother. Clamped where the sheet would fall
  /// apart, with a warning. Range: (0, 100].
  double detail = 1;
  /// Kernel width as a share of the diagonal, instead of the automatic one. Range: > 0; 0 = automatic.
  double sigma0_rel = 0;
  /// Vertices of the covariance mesh, at most: the kernel is as much wider than the automatic one as it takes, and the
  /// fit stops refining there (choose_scale.h). Range: >= 4; 0 = no limit.
  std::size_t budget = 0;
  /// Widen the kernel as far as the error of the surface, as measured on points that are held out (choose_scale.h),
  /// stays within this share of the diagonal. Range: > 0; 0 = automatic width.
  double max_error_rel = 0;
  /// Compare kernel widths by the likelihood of points that are held out (choose_scale.h), for the report only.
  bool check_scale = false;
  /// Refinement level of the mesh. Range: [0, 8]; -1 = the smallest level up to 3 whose edges are at most 1.5 times the
  /// sample spacing.
  int levels = -1;
  /// Instead of a level everywhere, split faces until the mesh is nowhere farther from the limit surface than this
  /// share of the diagonal (without points: of the bounding box of the control means). Excludes `levels`. Range: > 0; 0
  /// = off.
  double tolerance_rel = 0;
  /// Count the faces of covariance mesh and mesh that intersect others.
  bool self_intersections = false;
  /// Where the sensor stood, in world coordinates; takes precedence over the sensors and normals of the points.
  std::optional<Vec3> sensor;

  /// Throws OptionError naming the field and the value, or two that contradict each other.
  void check() const;
};

/// The points the stages work on, and the scale found in them.
struct PreparedCloud {
  CleanCloud clean;  ///< without the isolated points
  Scale scale;       ///< in local units; `isolated` refers to the points before they were dropped
  std::size_t isolated = 0;
  double diagonal = 0;  ///< bounding-box diagonal of the remaining points, local units
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
/// `budget`, `max_error_rel` and `check_scale` are refused.
Reconstruction reconstruct(const Mixture& mixture, const ReconstructOptions& options = {},
                           const RunContext& context = {});
Reconstruction reconstruct(const CovMesh& mesh, const ReconstructOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
