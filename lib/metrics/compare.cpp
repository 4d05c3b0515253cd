#include <gpsrecon/core/error.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/metrics/compare.h>
#include <gpsrecon/metrics/mesh_measures.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace gpsrecon {
namespace {

/// Random streams of the samples on the two surfaces.
constexpr std::uint64_t mesh_stream = 0x6D657368, reference_stream = 0x72656665;

/// The mesh with its positions in `frame`; only positions and faces are carried over if they have to change.
Mesh moved_to(const Mesh& mesh, const Frame& frame) {
  Mesh moved;
  moved.frame = frame;
  moved.faces = mesh.faces;
  moved.positions.reserve(mesh.positions.size());
  for (const Vec3& p : mesh.positions) moved.positions.push_back(frame.to_local(mesh.frame.to_world(p)));
  return moved;
}

void require_faces(const Mesh& mesh, const char* what) {
  if (mesh.faces.empty()) throw InvariantError(std::string("compare: the ") + what + " has no faces");
}

/// Of the vertices that faces use, in the units of the positions.
double used_diagonal(const Mesh& mesh) {
  const Index first = mesh.faces.corners.at(0);
  Vec3 low = mesh.positions.at(first), high = low;
  for (const Index v : mesh.faces.corners) {
    low = low.cwiseMin(mesh.positions[v]);
    high = high.cwiseMax(mesh.positions[v]);
  }
  return (high - low).norm();
}

DistanceReport summarise(const std::vector<ClosestPoint>& found, std::span<const Vec3> points,
                         std::span<const double> weights, const Frame& frame, double diagonal,
                         const RunContext& context) {
  std::vector<double> values(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) values[i] = found[i].distance * frame.scale();
  DistanceReport report;
  report.distance = statistics(values, weights, context);
  if (!points.empty()) report.max_at = frame.to_world(points[report.distance.index_of_max]);
  if (diagonal > 0) {
    for (double& d : values) d /= diagonal;
    report.histogram = histogram(values, decade_edges(), weights);
  }
  return report;
}

/// Per face: twice the area times the unit normal.
Vec3 area_vector(const Mesh& mesh, Index f) {
  const auto face = mesh.faces[f];
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 2; k < face.size(); ++k) {
    const Vec3& a = mesh.positions[face[0]];
    sum += (mesh.positions[face[k - 1]] - a).cross(mesh.positions[face[k]] - a);
  }
  return sum;
}

NormalReport compare_normals(const Mesh& from, const std::vector<Index>& from_faces, const Mesh& to,
                             const std::vector<ClosestPoint>& found, const RunContext& context) {
  constexpr double no_angle = -1;
  std::vector<double> degrees(found.size());
  parallel_for(found.size(), context, [&](std::size_t i) {
    const Vec3 a = area_vector(from, from_faces[i]).stableNormalized();
    const Vec3 b = area_vector(to, found[i].face).stableNormalized();
    const bool defined = a.squaredNorm() > 0.5 && b.squaredNorm() > 0.5;
    degrees[i] = defined ? std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi : no_angle;
  });
  std::erase(degrees, no_angle);
  NormalReport report;
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

DirectionReport one_way(const Mesh& from, const Mesh& to, const SurfaceDistance& surface, double diagonal,
                        std::size_t sample_count, std::uint64_t stream, const RunContext& context) {
  const AreaSamples samples = sample_surface(from, sample_count, stream, context);
  const std::vector<ClosestPoint> found = surface.distances(samples.positions, context);
  return {summarise(found, samples.positions, {}, from.frame, diagonal, context),
          compare_normals(from, samples.faces, to, found, context)};
}

}  // namespace

void CompareOptions::check() const {
  if (samples < 1 || samples > 1000000000)
    throw OptionError("samples must be in [1, 1e9], not " + std::to_string(samples));
}

AreaSamples sample_surface(const Mesh& mesh, std::size_t count, std::uint64_t stream, const RunContext& context) {
  struct Triangle {
    Index a, b, c, face;
  };
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.faces.corners.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    for (std::size_t k = 2; k < face.size(); ++k)
      triangles.push_back({face[0], face[k - 1], face[k], static_cast<Index>(f)});
  }
  std::vector<double> area_before(triangles.size() + 1, 0);  // running sum, so the area of t ends at t + 1
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3& a = mesh.positions[triangles[t].a];
    area_before[t + 1] =
        area_before[t] + (mesh.positions[triangles[t].b] - a).cross(mesh.positions[triangles[t].c] - a).norm() / 2;
  }
  const double total = area_before.back();
  if (!(total > 0) || !std::isfinite(total)) throw InvariantError("sampling: the surface has no finite, positive area");

  AreaSamples samples;
  samples.positions.resize(count);
  samples.faces.resize(count);
  parallel_for(count, context, [&](std::size_t i) {
    const auto uniform = [&](std::uint64_t k) { return random_uniform(context.seed, stream, 3 * i + k); };
    const double strip = (static_cast<double>(i) + uniform(0)) / static_cast<double>(count);
    // The first triangle that ends after the place; rounding may put the last one at the very end. Either way it is
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

DistanceReport measure_distances(const SurfaceDistance& surface, const PointCloud& cloud, double diagonal,
                                 const RunContext& context) {
  return summarise(surface.distances(cloud.positions, context), cloud.positions, cloud.weights, cloud.frame, diagonal,
                   context);
}

ErrorReport compare(const Mesh& mesh, const PointCloud& cloud, const CompareOptions& options,
                    const RunContext& context) {
  options.check();
  require_faces(mesh, "mesh");
  if (cloud.empty()) throw InvariantError("compare: the cloud has no points");
  ErrorReport report;
  report.command = "compare";
  report.seed = context.seed;
  report.diagonal = bounding_box_diagonal(cloud.positions) * cloud.frame.scale();
  report.input = InputReport{{}, cloud.size(), report.diagonal};
  report.mesh = measure_mesh(mesh, context, options.self_intersections);
  const SurfaceDistance surface = mesh.frame == cloud.frame ? SurfaceDistance(mesh, context)
                                                            : SurfaceDistance(moved_to(mesh, cloud.frame), context);
  report.points_to_surface = measure_distances(surface, cloud, report.diagonal, context);
  return report;
}

ErrorReport compare(const Mesh& mesh, const Mesh& reference, const CompareOptions& options, const RunContext& context) {
  options.check();
  require_faces(mesh, "mesh");
  require_faces(reference, "reference");
  if (!(mesh.frame == reference.frame)) return compare(moved_to(mesh, reference.frame), reference, options, context);
  const SurfaceDistance surface(mesh, context), truth(reference, context);  // check the corners before all else
  ErrorReport report;
  report.command = "compare";
  report.seed = context.seed;
  report.diagonal = used_diagonal(reference) * reference.frame.scale();
  report.mesh = measure_mesh(mesh, context, options.self_intersections);
  ReferenceReport& result = report.reference.emplace();
  result.diagonal = report.diagonal;
  result.samples = options.samples;
  result.mesh_to_reference = one_way(mesh, reference, truth, report.diagonal, options.samples, mesh_stream, context);
  result.reference_to_mesh =
      one_way(reference, mesh, surface, report.diagonal, options.samples, reference_stream, context);
  return report;
}

}  // namespace gpsrecon
