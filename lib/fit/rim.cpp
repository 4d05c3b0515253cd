#include <gpsrecon/fit/rim.h>

#include <gpsrecon/core/mesh_topology.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gpsrecon::internal {
namespace {

/// Points farther beyond the rim than this many spacings belong to something else.
constexpr double farthest_beyond = 4;

/// Weighted sums that an average is the ratio of.
using WeightedSum = Eigen::Vector2d;  // (Σ w x, Σ w)

}  // namespace

Rim find_rim(const LimitSurface& surface) {
  Rim rim;
  rim.position.assign(surface.sample_count(), no_index);
  for (const std::vector<Index>& loop : boundary_loops(surface.connectivity()))
    for (std::size_t k = 0; k < loop.size(); ++k) {
      rim.position[loop[k]] = static_cast<Index>(rim.sample.size());
      rim.sample.push_back(loop[k]);
      rim.previous.push_back(loop[(k + loop.size() - 1) % loop.size()]);
      rim.next.push_back(loop[(k + 1) % loop.size()]);
    }
  return rim;
}

void extend_rim(const LimitSurface& surface, const Rim& rim, const SurfaceSamples& samples,
                const Assignment& assignment, const PointCloud& cloud, double thickness, Mixture& control) {
  const double spacing = control.spacing;
  if (rim.sample.empty() || !(spacing > 0)) return;
  const std::size_t n = rim.sample.size();
  std::vector<Vec3> outward(n);
  std::vector<double> length(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3 along = samples.positions[rim.next[k]] - samples.positions[rim.previous[k]];
    length[k] = 0.5 * along.norm();
    outward[k] = along.cross(samples.normals[rim.sample[k]]).stableNormalized();
  }
  std::vector<WeightedSum> beyond(n, WeightedSum::Zero());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Index k = rim.position[assignment.sample[i]];
    if (k == no_index || std::abs(assignment.offset[i]) > thickness) continue;
    const double distance = outward[k].dot(cloud.positions[i] - samples.positions[rim.sample[k]]);
    if (distance > 0 && distance < farthest_beyond * spacing)
      beyond[k] += WeightedSum(cloud.weight(i) * distance, cloud.weight(i));
  }
  std::vector<WeightedSum> sums(surface.sample_count(), WeightedSum::Zero());
  for (std::size_t k = 0; k < n; ++k) {
    double width = 0;
    if (beyond[k][1] > 0 && length[k] > 0)
      width = std::min(2 * beyond[k][0] / beyond[k][1], beyond[k][1] * spacing * spacing / length[k]);
    sums[rim.sample[k]] = WeightedSum(length[k] * width, length[k]);
  }
  const std::vector<WeightedSum> pulled = surface.to_control<WeightedSum>(sums);
  for (std::size_t v = 0; v < pulled.size(); ++v)
    if (rim.position[v] != no_index && pulled[v][1] > 0)
      control.means[v] += pulled[v][0] / pulled[v][1] * outward[rim.position[v]];
}

}  // namespace gpsrecon::internal
