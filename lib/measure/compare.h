#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <gpsrecon/measure/statistics.h>
#include <optional>

namespace gpsrecon {

// Lengths in scene units (those of the files), positions in world coordinates; a length over the diagonal D of the
// comparison is called relative.

/// Distances from points to a surface.
struct DistanceMeasures {
  Statistics distance;                 ///< scene units; index_of_max counts the points or samples measured
  Vec3 max_at = Vec3::Zero();          ///< the farthest point
  std::optional<Histogram> histogram;  ///< over the distance relative to D; absent if D is 0
};

/// Angles between face normals of a sample and of the surface point closest to it, in degrees, where both faces have an
/// area.
struct NormalMeasures {
  std::size_t count = 0;
  double mean = 0, p95 = 0;  ///< of the angle between the lines, in [0, 90]: orientation does not count
  double flipped = 0;        ///< share of normals that point to opposite sides (more than 90°), in [0, 1]
};

/// From samples of one shape to their footpoints on another.
struct DirectionMeasures {
  DistanceMeasures distance;
  NormalMeasures normals;  ///< empty where one of the two has no normals
  /// Mean distance, positive on the side of the normals there: a surface that lies outside as often as inside has none.
  /// Scene units; absent where the other shape has no normals.
  std::optional<double> signed_mean;
  double within = 0;               ///< share of the samples that are found, see Thresholds
  double far = 0;                  ///< share of those that are farther than the other threshold
  std::optional<double> far_area;  ///< of that share, in squared scene units; absent for points
};

/// Distances as shares of D.
struct Thresholds {
  double fscore_rel = 0;  ///< up to which a sample is found
  double far_rel = 0;     ///< beyond which it is spurious or missing
};

/// A mesh (or points) against ground truth, both ways: the first tells how accurate it is, the second how complete.
struct ReferenceMeasures {
  double diagonal = 0;      ///< of the reference
  std::size_t samples = 0;  ///< area-uniform samples on each surface
  Thresholds thresholds;
  DirectionMeasures mesh_to_reference, reference_to_mesh;
  /// Harmonic mean of precision and recall, the shares `within` of the two directions; 0 if both are.
  double f_score() const;
};

/// What was measured; what does not apply is absent.
struct Comparison {
  double diagonal = 0;               ///< D
  std::size_t points = 0;            ///< of the cloud that was compared, if it was one
  double points_diagonal = 0;        ///< of that cloud
  std::optional<MeshMeasures> mesh;  ///< of the mesh that was compared
  std::optional<DistanceMeasures> points_to_surface;
  std::optional<DirectionMeasures> surface_to_points;  ///< samples of the surface to the nearest point
  std::optional<Thresholds> thresholds;                ///< of that
  std::optional<ReferenceMeasures> reference;
};

struct CompareOptions {
  std::size_t samples = 400000;
  bool self_intersections = false;
  Length fscore = Length::of_diagonal(0.0025);
  Length far = Length::of_diagonal(0.01);

  static OptionTable fields() {
    using O = CompareOptions;
    return {field<&O::samples>("samples", "[1, 1e9]", "points drawn on each mesh, uniform by area"),
            field<&O::fscore>("fscore", "> 0",
                              "distance within which a sample counts as found, for precision, recall and F-score; the "
                              "diagonal is that of REFERENCE"),
            field<&O::far>("far", "> 0", "distance beyond which surface counts as spurious or missing"),
            field<&O::self_intersections>("self-intersections", "",
                                          "count the faces of SHAPE, if it is a mesh, that intersect others")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// Points on the faces of a mesh, in the units of its positions.
struct AreaSamples {
  std::vector<Vec3> positions;
  std::vector<Index> faces;  ///< face of each
};

/// `count` points uniform by area: the total area is cut into `count` equal strips in the order of the faces, and each
/// gets one point (stratified sampling), drawn from (seed, stream). The same bytes for any number of threads.
/// Throws InvariantError if the area is zero or not finite.
AreaSamples sample_surface(const Mesh& mesh, std::size_t count, std::uint64_t stream, const RunContext& context = {});

/// Distances of the points of a cloud to a surface in the cloud's frame, each counted with its weight (the number of
/// input points it stands for). The histogram is over distances relative to `diagonal` (scene units; 0: none). Throws
/// InvariantError if the surface is empty or a point is not finite.
DistanceMeasures measure_distances(const SurfaceDistance& surface, const PointCloud& cloud, double diagonal,
                                   const RunContext& context = {});

/// How far a cloud is from a mesh: points_to_surface, surface_to_points, mesh and points. D is the diagonal of the
/// cloud. This measures agreement with the points, not accuracy: it sees no errors that the points share. Surface that
/// was made up where there are no points shows in surface_to_points, beside the gaps between points. Throws
/// OptionError; InvariantError if the cloud has no points, the mesh no faces, or a number is not finite.
Comparison compare(const Mesh& mesh, const PointCloud& cloud, const CompareOptions& options = {},
                   const RunContext& context = {});

/// A mesh against ground truth, both ways, with normals: reference and mesh. D is the diagonal of the
/// used vertices of the reference. Exact point-to-triangle distances from seeded samples (RunContext::seed). O((n +
/// samples) log n). Throws OptionError; InvariantError if one of them has no area or a number is not finite.
Comparison compare(const Mesh& mesh, const Mesh& reference, const CompareOptions& options = {},
                   const RunContext& context = {});

/// A cloud against a reference, both ways: reference and points; all its points, each with its weight,
/// against samples of a mesh, or point to nearest point. D is the diagonal of the reference. Normals are compared where
/// both have them. Throws OptionError; InvariantError if one of them is empty or a number is not finite.
Comparison compare(const PointCloud& cloud, const Mesh& reference, const CompareOptions& options = {},
                   const RunContext& context = {});
Comparison compare(const PointCloud& cloud, const PointCloud& reference, const CompareOptions& options = {},
                   const RunContext& context = {});

}  // namespace gpsrecon
