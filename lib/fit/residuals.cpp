// Iteratively reweighted least squares with Tukey's biweight: Holland & Welsch 1977.

#include <gpsrecon/fit/residuals.h>

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>

namespace gpsrecon::internal {
namespace {

/// Fewer points around a control vertex say nothing about its scale.
constexpr std::size_t min_points_for_scale = 3;

void measure_offsets(const SurfaceSamples& samples, const PointCloud& cloud, const RunContext& context,
                     Assignment& assignment) {
  parallel_for(cloud.size(), context, [&](std::size_t i) {
    const Index s = assignment.sample[i];
    assignment.offset[i] = samples.normals[s].dot(cloud.positions[i] - samples.positions[s]);
  });
}

/// Larger than this many median offsets of all points the scale does not become: where only outliers are left around a
/// vertex, they would pull the surface out to more of them.
constexpr double largest_scale = 10;

/// Per control vertex: the median |offset| of the points at its samples, but at least `floor` and at most a few times
/// that.
std::vector<double> local_scales(const std::vector<Index>& control, std::size_t control_count,
                                 const Assignment& assignment, double floor) {
  std::vector<std::uint32_t> begin(control_count + 1, 0);
  for (const Index s : assignment.sample) ++begin[control[s] + 1];
  for (std::size_t v = 0; v < control_count; ++v) begin[v + 1] += begin[v];
  std::vector<double> grouped(assignment.sample.size());
  std::vector<std::uint32_t> cursor(begin.begin(), begin.end() - 1);
  for (std::size_t i = 0; i < grouped.size(); ++i)
    grouped[cursor[control[assignment.sample[i]]]++] = std::abs(assignment.offset[i]);
  std::vector<double> scale(control_count, floor);
  for (std::size_t v = 0; v < control_count; ++v)
    if (begin[v + 1] - begin[v] >= min_points_for_scale)
      scale[v] = std::clamp(median(std::span(grouped).subspan(begin[v], begin[v + 1] - begin[v])), floor,
                            largest_scale * floor);
  return scale;
}

}  // namespace

SampleGraph sample_graph(const LimitSurface& surface) {
  const Connectivity& connectivity = surface.connectivity();
  SampleGraph graph;
  graph.offset.reserve(surface.sample_count() + 1);
  graph.next.reserve(2 * connectivity.edge_count());
  graph.offset.push_back(0);
  for (Index s = 0; s < surface.sample_count(); ++s) {
    connectivity.for_each_neighbor(s, [&](Index neighbor) { graph.next.push_back(neighbor); });
    graph.offset.push_back(static_cast<std::uint32_t>(graph.next.size()));
  }
  return graph;
}

Assignment assign_points(const SurfaceSamples& samples, const PointCloud& cloud, const RunContext& context) {
  const Neighbors index(samples.positions);
  Assignment assignment{std::vector<Index>(cloud.size()), std::vector<double>(cloud.size())};
  parallel_blocks(cloud.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> found;
    for (std::size_t i = begin; i < end; ++i) {
      index.nearest(cloud.positions[i], 1, found);
      assignment.sample[i] = found.front().index;
    }
  });
  measure_offsets(samples, cloud, context, assignment);
  return assignment;
}

void reassign_points(const SurfaceSamples& samples, const SampleGraph& graph, const PointCloud& cloud,
                     const RunContext& context, Assignment& assignment) {
  parallel_for(cloud.size(), context, [&](std::size_t i) {
    const Vec3& point = cloud.positions[i];
    Index at = assignment.sample[i];
    double distance2 = (samples.positions[at] - point).squaredNorm();
    for (bool moved = true; moved;) {
      moved = false;
      const Index from = at;
      for (std::uint32_t e = graph.offset[from]; e < graph.offset[from + 1]; ++e) {
        const double candidate2 = (samples.positions[graph.next[e]] - point).squaredNorm();
        if (candidate2 >= distance2) continue;
        distance2 = candidate2;
        at = graph.next[e];
        moved = true;
      }
    }
    assignment.sample[i] = at;
  });
  measure_offsets(samples, cloud, context, assignment);
}

double median_offset(const Assignment& assignment) {
  std::vector<double> magnitudes(assignment.offset.size());
  std::transform(assignment.offset.begin(), assignment.offset.end(), magnitudes.begin(),
                 [](double d) { return std::abs(d); });
  return median(magnitudes);
}

Residuals robust_residuals(const LimitSurface& surface, const Assignment& assignment, const PointCloud& cloud,
                           const std::vector<char>& held_out, double scale) {
  const std::vector<Index> control = surface.control_of_samples();
  const std::vector<double> scales = local_scales(control, surface.control_count(), assignment, scale);
  const std::vector<double> zero(surface.sample_count(), 0.0);
  Residuals sums{zero, zero, zero};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (held_out[i]) continue;
    const Index s = assignment.sample[i];
    const double d = assignment.offset[i];
    // Infinite for a point off a surface that most points lie in exactly (scale 0).
    const double u = d != 0 ? d / (outlier_distance * scales[control[s]]) : 0;
    if (std::abs(u) >= 1) continue;
    const double weight = cloud.weight(i) * (1 - u * u) * (1 - u * u);
    sums.weight[s] += weight;
    sums.moment[s] += weight * d;
    sums.square[s] += weight * d * d;
  }
  return sums;
}

}  // namespace gpsrecon::internal
