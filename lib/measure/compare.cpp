// Distances of samples of one surface from the other, both ways: Cignoni et al. 1998; F-score: Knapitsch et al.
// 2017.

#include <gpsrecon/measure/compare.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

/// Random streams of the samples on the two surfaces.
constexpr std::uint64_t mesh_stream = 0x6D657368, reference_stream = 0x72656665;

void require_faces(const Mesh& mesh, const char* what) {
  if (mesh.faces.empty()) throw InvariantError(std::string("compare: the ") + what + " has no faces");
}

/// Of the vertices that faces use, in the units of the positions.
double used_diagonal(const Mesh& mesh) {
  return diagonal_length(bounding_box(mesh.positions, mesh.faces.corners));
}

DistanceMeasures summarise(const std::vector<ClosestPoint>& found, std::span<const Vec3> points,
                           std::span<const double> weights, const Frame& frame, double diagonal,
                           const RunContext& context) {
  std::vector<double> values(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) values[i] = found[i].distance * frame.scale();
  DistanceMeasures report;
  report.distance = statistics(values, weights, context);
  if (!points.empty()) report.max_at = frame.to_world(points[report.distance.index_of_max]);
  if (diagonal > 0) {
    for (double& d : values) d /= diagonal;
    report.histogram = histogram(values, decade_edges(), weights);
  }
  return report;
}

/// Unit normals of a shape by number of face or point; zero where there is none.
using Normals = std::function<Vec3(Index)>;

/// Where distances are measured from.
struct Samples {
  std::span<const Vec3> positions;
  std::span<const double> weights;  ///< empty: one each
  std::vector<Vec3> normals;        ///< empty: unknown
  std::optional<double> area;       ///< of the surface they are drawn from, in squared units of the positions
};

/// Where they are measured to.
struct Target {
  std::vector<ClosestPoint> found;
  Normals normal;  ///< empty: unknown
};

NormalMeasures compare_normals(const Samples& samples, const Target& target, const RunContext& context) {
  constexpr double no_angle = -1;
  std::vector<double> degrees(target.found.size());
  parallel_for(target.found.size(), context, [&](std::size_t i) {
    const Vec3 &a = samples.normals[i], b = target.normal(target.found[i].face);
    const bool defined = a.squaredNorm() > 0.5 && b.squaredNorm() > 0.5;
    degrees[i] = defined ? std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi : no_angle;
  });
  std::erase(degrees, no_angle);
  NormalMeasures report;
  report.count = degrees.size();
  if (degrees.empty()) return report;
  std::size_t flipped = 0;
  for (double& d : degrees)
    if (d > 90) {
      ++flipped;
      d = 180 - d;
    }
  const Statistics angles = statistics(degrees, {}, context);
  report.mean = angles.mean;
  report.p95 = angles.p95;
  report.flipped = static_cast<double>(flipped) / static_cast<double>(degrees.size());
  return report;
}

/// Mean distance with the sign of the side of the normals, in the units of the positions.
double signed_mean(const Samples& samples, const Target& target, const RunContext& context) {
  const auto weight = [&](std::size_t i) { return samples.weights.empty() ? 1 : samples.weights[i]; };
  const std::size_t n = target.found.size();
  const double sum = parallel_sum<double>(n, context, [&](std::size_t i) {
    const ClosestPoint& at = target.found[i];
    const bool below = target.normal(at.face).dot(samples.positions[i] - at.point) < 0;
    return weight(i) * (below ? -at.distance : at.distance);
  });
  return sum / parallel_sum<double>(n, context, weight);
}

DirectionMeasures one_way(const Samples& samples, const Target& target, const Frame& frame, double diagonal,
                          const Thresholds& thresholds, const RunContext& context) {
  DirectionMeasures report;
  report.distance = summarise(target.found, samples.positions, samples.weights, frame, diagonal, context);
  if (target.normal) {
    report.signed_mean = frame.scale() * signed_mean(samples, target, context);
    if (!samples.normals.empty()) report.normals = compare_normals(samples, target, context);
  }
  const auto weight = [&](std::size_t i) { return samples.weights.empty() ? 1 : samples.weights[i]; };
  double all = 0, within = 0, far = 0;
  for (std::size_t i = 0; i < target.found.size(); ++i) {
    const double distance = target.found[i].distance * frame.scale();
    all += weight(i);
    if (distance <= thresholds.fscore_rel * diagonal) within += weight(i);
    if (distance > thresholds.far_rel * diagonal) far += weight(i);
  }
  report.within = within / all;
  report.far = far / all;
  if (samples.area) report.far_area = report.far * *samples.area * frame.scale() * frame.scale();
  return report;
}

/// A mesh or a cloud in the role of one to be measured from and to. All in one frame.
class Shape {
 public:
  Shape(const Mesh& mesh, std::size_t samples, std::uint64_t stream, const RunContext& context)
      : mesh_(&mesh), surface_(std::make_unique<SurfaceDistance>(mesh, context)) {
    drawn_ = sample_surface(mesh, samples, stream, context);
    samples_.positions = drawn_.positions;
    samples_.area = surface_area(mesh.positions, mesh.faces, context);
    samples_.normals.resize(drawn_.faces.size());
    parallel_for(drawn_.faces.size(), context, [&](std::size_t i) { samples_.normals[i] = normal(drawn_.faces[i]); });
  }
  explicit Shape(const PointCloud& cloud) : cloud_(&cloud), index_(std::make_unique<Neighbors>(cloud.positions)) {
    samples_.positions = cloud.positions;
    samples_.weights = cloud.weights;
    samples_.normals = cloud.normals;
    for (Vec3& n : samples_.normals) n = n.stableNormalized();
  }

  const Samples& samples() const { return samples_; }

  Target nearest_to(std::span<const Vec3> points, const RunContext& context) const {
    Target target;
    if (mesh_ != nullptr || !cloud_->normals.empty()) target.normal = [this](Index i) { return normal(i); };
    if (surface_) {
      target.found = surface_->distances(points, context);
      return target;
    }
    target.found.resize(points.size());
    parallel_blocks(points.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
      std::vector<Neighbor> nearest;
      for (std::size_t i = begin; i < end; ++i) {
        index_->nearest(points[i], 1, nearest);
        target.found[i] = {nearest[0].distance, cloud_->positions[nearest[0].index], nearest[0].index};
      }
    });
    return target;
  }

 private:
  Vec3 normal(Index i) const {
    return mesh_ != nullptr ? unit_normal(mesh_->positions, mesh_->faces[i]) : cloud_->normals[i].stableNormalized();
  }

  const Mesh* mesh_ = nullptr;
  const PointCloud* cloud_ = nullptr;
  std::unique_ptr<SurfaceDistance> surface_;
  std::unique_ptr<Neighbors> index_;
  AreaSamples drawn_;
  Samples samples_;
};

void require_points(const PointCloud& cloud, const char* what) {
  const auto finite = [](const Vec3& p) { return p.allFinite(); };
  if (!std::all_of(cloud.positions.begin(), cloud.positions.end(), finite))
    throw InvariantError(std::string("compare: the ") + what + " has a point that is not finite");
  if (cloud.empty()) throw InvariantError(std::string("compare: the ") + what + " has no points");
}

DirectionMeasures one_way(const Shape& from, const Shape& to, const Frame& frame, double diagonal,
                          const Thresholds& thresholds, const RunContext& context) {
  return one_way(from.samples(), to.nearest_to(from.samples().positions, context), frame, diagonal, thresholds,
                 context);
}

/// As shares of the diagonal (scene units).
Thresholds thresholds_of(const CompareOptions& options, double diagonal) {
  const LengthScale shares{.diagonal = 1, .scene_to_local = diagonal > 0 ? 1 / diagonal : 0};
  return {options.fscore.resolve(shares, "fscore"), options.far.resolve(shares, "far")};
}

/// The parts that all comparisons with a reference have in common; both are in `frame`.
Comparison against_reference(const Shape& shape, const Shape& reference, const Frame& frame, double diagonal,
                             const CompareOptions& options, const RunContext& context) {
  Comparison report;
  report.diagonal = diagonal;
  ReferenceMeasures& result = report.reference.emplace();
  result.diagonal = diagonal;
  result.samples = options.samples;
  result.thresholds = thresholds_of(options, diagonal);
  result.mesh_to_reference = one_way(shape, reference, frame, diagonal, result.thresholds, context);
  result.reference_to_mesh = one_way(reference, shape, frame, diagonal, result.thresholds, context);
  return report;
}

}  // namespace

double ReferenceMeasures::f_score() const {
  const double precision = mesh_to_reference.within, recall = reference_to_mesh.within;
  return precision + recall > 0 ? 2 * precision * recall / (precision + recall) : 0;
}

AreaSamples sample_surface(const Mesh& mesh, std::size_t count, std::uint64_t stream, const RunContext& context) {
  struct Triangle {
    Index a, b, c, face;
  };
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.faces.corners.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for_each_triangle(mesh.faces[f], [&](Index a, Index b, Index c) {
      triangles.push_back({a, b, c, static_cast<Index>(f)});
    });
  }
  std::vector<double> area_before(triangles.size() + 1, 0);  // running sum, so the area of t ends at t + 1
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c, face] = triangles[t];
    area_before[t + 1] =
        area_before[t] + area_vector(mesh.positions[a], mesh.positions[b], mesh.positions[c]).norm() / 2;
  }
  const double total = area_before.back();
  if (!(total > 0) || !std::isfinite(total)) throw InvariantError("sampling: the surface has no finite, positive area");

  AreaSamples samples;
  samples.positions.resize(count);
  samples.faces.resize(count);
  parallel_for(count, context, [&](std::size_t i) {
    const auto uniform = [&](std::uint64_t k) { return random_uniform(context.seed, stream, 3 * i + k); };
    const double strip = (static_cast<double>(i) + uniform(0)) / static_cast<double>(count);
    // The first triangle that ends after that area; rounding may put the last one at the very end. Either way it is
    // one with an area, because equal sums are skipped.
    auto end = std::upper_bound(area_before.begin() + 1, area_before.end(), strip * total);
    if (end == area_before.end()) end = std::lower_bound(area_before.begin() + 1, area_before.end(), total);
    const Triangle& t = triangles[static_cast<std::size_t>(end - area_before.begin()) - 1];
    const double r = std::sqrt(uniform(1)), s = uniform(2);
    samples.positions[i] =
        (1 - r) * mesh.positions[t.a] + r * (1 - s) * mesh.positions[t.b] + r * s * mesh.positions[t.c];
    samples.faces[i] = t.face;
  });
  return samples;
}

DistanceMeasures measure_distances(const SurfaceDistance& surface, const PointCloud& cloud, double diagonal,
                                   const RunContext& context) {
  return summarise(surface.distances(cloud.positions, context), cloud.positions, cloud.weights, cloud.frame, diagonal,
                   context);
}

Comparison compare(const Mesh& mesh, const PointCloud& cloud, const CompareOptions& options,
                   const RunContext& context) {
  options.check();
  require_faces(mesh, "mesh");
  require_points(cloud, "cloud");
  if (!(mesh.frame == cloud.frame)) return compare(in_frame(mesh, cloud.frame), cloud, options, context);
  Comparison report;
  report.diagonal = bounding_box_diagonal(cloud.positions) * cloud.frame.scale();
  report.points = cloud.size();
  report.points_diagonal = report.diagonal;
  const SurfaceDistance surface(mesh, context);  // checks the corners before all else
  report.points_to_surface = measure_distances(surface, cloud, report.diagonal, context);
  report.mesh = measure_mesh(mesh, context, options.self_intersections);
  // A surface without area has distances to it, and no points to measure from.
  if (!(report.mesh->area > 0)) return report;
  report.thresholds = thresholds_of(options, report.diagonal);
  report.surface_to_points = one_way(Shape(mesh, options.samples, mesh_stream, context), Shape(cloud), cloud.frame,
                                     report.diagonal, *report.thresholds, context);
  return report;
}

Comparison compare(const Mesh& mesh, const Mesh& reference, const CompareOptions& options, const RunContext& context) {
  options.check();
  require_faces(mesh, "mesh");
  require_faces(reference, "reference");
  if (!(mesh.frame == reference.frame)) return compare(in_frame(mesh, reference.frame), reference, options, context);
  const Shape shape(mesh, options.samples, mesh_stream, context),
      truth(reference, options.samples, reference_stream, context);
  Comparison report = against_reference(shape, truth, reference.frame,
                                        used_diagonal(reference) * reference.frame.scale(), options, context);
  report.mesh = measure_mesh(mesh, context, options.self_intersections);
  return report;
}

Comparison compare(const PointCloud& cloud, const Mesh& reference, const CompareOptions& options,
                   const RunContext& context) {
  options.check();
  require_points(cloud, "cloud");
  require_faces(reference, "reference");
  if (!(cloud.frame == reference.frame)) return compare(in_frame(cloud, reference.frame), reference, options, context);
  const Shape shape(cloud), truth(reference, options.samples, reference_stream, context);
  Comparison report = against_reference(shape, truth, reference.frame,
                                        used_diagonal(reference) * reference.frame.scale(), options, context);
  report.points = cloud.size();
  report.points_diagonal = bounding_box_diagonal(cloud.positions) * cloud.frame.scale();
  return report;
}

Comparison compare(const PointCloud& cloud, const PointCloud& reference, const CompareOptions& options,
                   const RunContext& context) {
  options.check();
  require_points(cloud, "cloud");
  require_points(reference, "reference");
  if (!(cloud.frame == reference.frame)) return compare(in_frame(cloud, reference.frame), reference, options, context);
  Comparison report =
      against_reference(Shape(cloud), Shape(reference), reference.frame,
                        bounding_box_diagonal(reference.positions) * reference.frame.scale(), options, context);
  report.points = cloud.size();
  report.points_diagonal = bounding_box_diagonal(cloud.positions) * cloud.frame.scale();
  return report;
}

}  // namespace gpsrecon
