// Iterated closest points: Besl & McKay 1992 (to points), Chen & Medioni 1992 (to planes).

#include <gpsrecon/measure/align.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr std::uint64_t align_stream = 0x616C69676E;

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Where a point of the shape belongs, and the normal there; zero where there is none.
struct Match {
  Vec3 point, normal;
  double distance;
};
using Matcher = std::function<std::vector<Match>(const std::vector<Vec3>& points)>;

/// The motion that brings the points nearest to the planes through their matches, to first order (Chen and Medioni),
/// made a rotation.
Eigen::Isometry3d step_to_planes(const std::vector<Vec3>& points, const std::vector<Match>& matches,
                                 const std::vector<char>& used, const Vec3& center, double size) {
  Matrix6 a = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!used[i]) continue;
    const Vec3 arm = (points[i] - center) / size;
    Vector6 row;
    row << arm.cross(matches[i].normal), matches[i].normal;
    a += row * row.transpose();
    b += row * (matches[i].normal.dot(matches[i].point - points[i]) / size);
  }
  // A sphere may turn and a plane may slide as they like: then they stay.
  a += 1e-12 * a.trace() * Matrix6::Identity();
  const Vector6 x = a.ldlt().solve(b);
  const Vec3 turn = x.head<3>();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (turn.norm() > 0) motion.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  motion.translation() = center + size * x.tail<3>() - motion.linear() * center;
  return motion;
}

/// The motion that brings the points nearest to their matches.
Eigen::Isometry3d step_to_points(const std::vector<Vec3>& points, const std::vector<Match>& matches,
                                 const std::vector<char>& used) {
  const auto count = std::count(used.begin(), used.end(), 1);
  Eigen::Matrix3Xd from(3, count), to(3, count);
  Eigen::Index column = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!used[i]) continue;
    from.col(column) = points[i];
    to.col(column++) = matches[i].point;
  }
  Eigen::Isometry3d motion;
  motion.matrix() = Eigen::umeyama(from, to, false);
  return motion;
}

double rms(const std::vector<Match>& matches, const std::vector<char>& used) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (used[i]) sum += matches[i].distance * matches[i].distance, ++count;
  return count > 0 ? std::sqrt(sum / count) : 0;
}

/// Points no farther than `trim` median distances.
std::vector<char> close_enough(const std::vector<Match>& matches, double trim) {
  std::vector<double> distances;
  distances.reserve(matches.size());
  for (const Match& m : matches) distances.push_back(m.distance);
  const double farthest = trim * median(distances);
  std::vector<char> used(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) used[i] = matches[i].distance <= farthest ? 1 : 0;
  return used;
}

/// All in the frame of the reference; the motion is returned in world coordinates.
Alignment iterate(std::vector<Vec3> points, const Matcher& match, bool to_planes, double diagonal, const Frame& frame,
                  const AlignOptions& options, const RunContext& context) {
  if (points.empty()) throw InvariantError("align: the shape is empty");
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  Alignment report;
  for (; report.iterations < options.iterations && !report.converged; ++report.iterations) {
    context.throw_if_cancelled();
    const std::vector<Match> matches = match(points);
    const std::vector<char> used = close_enough(matches, options.trim);
    if (report.iterations == 0) report.rms_before = frame.scale() * rms(matches, used);
    Vec3 center = Vec3::Zero();
    for (const Vec3& p : points) center += p / static_cast<double>(points.size());
    const Eigen::Isometry3d step =
        to_planes ? step_to_planes(points, matches, used, center, diagonal) : step_to_points(points, matches, used);
    double largest = 0;
    for (Vec3& p : points) {
      const Vec3 next = step * p;
      largest = std::max(largest, (next - p).norm());
      p = next;
    }
    motion = step * motion;
    report.converged = largest <= options.convergence * diagonal;
  }
  const std::vector<Match> matches = match(points);
  report.rms_after = frame.scale() * rms(matches, close_enough(matches, options.trim));
  // From the frame of the reference to the world.
  report.rotation = motion.linear();
  report.translation = frame.to_world(motion * frame.to_local(Vec3::Zero()));
  return report;
}

std::vector<Vec3> places_of(const Mesh& mesh, const AlignOptions& options, const RunContext& context) {
  if (mesh.faces.empty()) throw InvariantError("align: the shape has no faces");
  return sample_surface(mesh, options.samples, align_stream, context).positions;
}

std::vector<Vec3> places_of(const PointCloud& cloud, const AlignOptions& options, const RunContext& context) {
  if (cloud.size() <= options.samples) return cloud.positions;
  std::vector<Vec3> chosen;
  for (std::size_t i = 0; i < options.samples; ++i) {
    const double at = random_uniform(context.seed, align_stream, i) * static_cast<double>(cloud.size());
    chosen.push_back(cloud.positions[std::min(static_cast<std::size_t>(at), cloud.size() - 1)]);
  }
  return chosen;
}

Alignment align_to(const Mesh& reference, std::vector<Vec3> points, const AlignOptions& options,
                   const RunContext& context) {
  if (reference.faces.empty()) throw InvariantError("align: the reference has no faces");
  const SurfaceDistance surface(reference, context);
  const auto match = [&](const std::vector<Vec3>& at) {
    const std::vector<ClosestPoint> found = surface.distances(at, context);
    std::vector<Match> matches(at.size());
    parallel_for(at.size(), context, [&](std::size_t i) {
      matches[i] = {found[i].point, unit_normal(reference.positions, reference.faces[found[i].face]),
                    found[i].distance};
    });
    return matches;
  };
  return iterate(std::move(points), match, true, bounding_box_diagonal(reference.positions), reference.frame, options,
                 context);
}

Alignment align_to(const PointCloud& reference, std::vector<Vec3> points, const AlignOptions& options,
                   const RunContext& context) {
  if (reference.empty()) throw InvariantError("align: the reference has no points");
  const Neighbors index(reference.positions);
  const auto match = [&](const std::vector<Vec3>& at) {
    std::vector<Match> matches(at.size());
    parallel_blocks(at.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
      std::vector<Neighbor> found;
      for (std::size_t i = begin; i < end; ++i) {
        index.nearest(at[i], 1, found);
        matches[i] = {reference.positions[found[0].index], Vec3::Zero(), found[0].distance};
      }
    });
    return matches;
  };
  return iterate(std::move(points), match, false, bounding_box_diagonal(reference.positions), reference.frame, options,
                 context);
}

template <class Shape, class Reference>
Alignment align_shapes(const Shape& shape, const Reference& reference, const AlignOptions& options,
                       const RunContext& context) {
  options.check();
  return align_to(reference, places_of(in_frame(shape, reference.frame), options, context), options, context);
}

}  // namespace

Alignment align(const Mesh& shape, const Mesh& reference, const AlignOptions& options, const RunContext& context) {
  return align_shapes(shape, reference, options, context);
}
Alignment align(const Mesh& shape, const PointCloud& reference, const AlignOptions& options,
                const RunContext& context) {
  return align_shapes(shape, reference, options, context);
}
Alignment align(const PointCloud& shape, const Mesh& reference, const AlignOptions& options,
                const RunContext& context) {
  return align_shapes(shape, reference, options, context);
}
Alignment align(const PointCloud& shape, const PointCloud& reference, const AlignOptions& options,
                const RunContext& context) {
  return align_shapes(shape, reference, options, context);
}

Mesh moved_by(const Mesh& mesh, const Alignment& motion) {
  Mesh moved = mesh;
  for (Vec3& p : moved.positions)
    p = mesh.frame.to_local(motion.rotation * mesh.frame.to_world(p) + motion.translation);
  for (Vec3& n : moved.normals) n = motion.rotation * n;
  for (Sym3& c : moved.covariances) c = congruence(motion.rotation, c);
  return moved;
}

PointCloud moved_by(const PointCloud& cloud, const Alignment& motion) {
  PointCloud moved = cloud;
  const auto move = [&](Vec3& p) {
    p = cloud.frame.to_local(motion.rotation * cloud.frame.to_world(p) + motion.translation);
  };
  std::for_each(moved.positions.begin(), moved.positions.end(), move);
  std::for_each(moved.sensors.begin(), moved.sensors.end(), move);
  for (Vec3& n : moved.normals) n = motion.rotation * n;
  return moved;
}

}  // namespace gpsrecon
