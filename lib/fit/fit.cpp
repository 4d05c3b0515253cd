#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/fit/fit.h>
#include <gpsrecon/gps/limit_surface.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

namespace gpsrecon {
namespace {

/// Tuning constant of Tukey's biweight (95 % efficient on normal noise), in robust standard deviations.
constexpr double biweight_tuning = 4.685;
constexpr double deviations_per_median = 1.4826;
/// Points farther beyond the rim than this many spacings belong to something else.
constexpr double farthest_beyond = 4;

/// Signed normal offset of every point from the surface sample closest to it.
struct Offsets {
  std::vector<Index> sample;
  std::vector<double> offset;
};

void measure_offsets(const SurfaceSamples& samples, const PointCloud& cloud, const RunContext& context,
                     Offsets& offsets) {
  parallel_for(cloud.size(), context, [&](std::size_t i) {
    const Index s = offsets.sample[i];
    offsets.offset[i] = samples.normals[s].dot(cloud.positions[i] - samples.positions[s]);
  });
}

Offsets find_offsets(const SurfaceSamples& samples, const PointCloud& cloud, const RunContext& context) {
  const Neighbors index(samples.positions);
  Offsets offsets{std::vector<Index>(cloud.size()), std::vector<double>(cloud.size())};
  parallel_blocks(cloud.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> found;
    for (std::size_t i = begin; i < end; ++i) {
      index.nearest(cloud.positions[i], 1, found);
      offsets.sample[i] = found.front().index;
    }
  });
  measure_offsets(samples, cloud, context, offsets);
  return offsets;
}

/// Next samples of every sample along the edges of the refined faces.
struct SampleGraph {
  std::vector<std::uint32_t> offset;
  std::vector<Index> next;
};

SampleGraph sample_graph(const LimitSurface& surface) {
  const FaceList& faces = surface.faces();
  SampleGraph graph{std::vector<std::uint32_t>(surface.sample_count() + 1, 0), {}};
  for (const Index v : faces.corners) graph.offset[v + 1] += 2;
  for (std::size_t s = 0; s < surface.sample_count(); ++s) graph.offset[s + 1] += graph.offset[s];
  graph.next.resize(graph.offset.back());
  std::vector<std::uint32_t> cursor(graph.offset.begin(), graph.offset.end() - 1);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    for (std::size_t k = 0; k < face.size(); ++k) {
      graph.next[cursor[face[k]]++] = face[(k + 1) % face.size()];
      graph.next[cursor[face[k]]++] = face[(k + face.size() - 1) % face.size()];
    }
  }
  return graph;
}

/// After a step the surface has moved little: from the sample of the step before, a walk along edges to ever closer
/// ones finds the closest again, at a fraction of the price of a search.
void follow_offsets(const SurfaceSamples& samples, const SampleGraph& graph, const PointCloud& cloud,
                    const RunContext& context, Offsets& offsets) {
  parallel_for(cloud.size(), context, [&](std::size_t i) {
    const Vec3& point = cloud.positions[i];
    Index at = offsets.sample[i];
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
    offsets.sample[i] = at;
  });
  measure_offsets(samples, cloud, context, offsets);
}

double median_magnitude(const std::vector<double>& values) {
  std::vector<double> magnitudes(values.size());
  std::transform(values.begin(), values.end(), magnitudes.begin(), [](double v) { return std::abs(v); });
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  return *middle;
}

/// Weighted sums that an average is the ratio of.
using WeightedSum = Eigen::Vector2d;  // (Σ w x, Σ w)

/// How far each control vertex is to move along its normal: the average of the offsets in its support, weighted by the
/// biweight of each and by the vertex's share in the surface there.
std::vector<double> average_offsets(const LimitSurface& surface, const Offsets& offsets, const PointCloud& cloud) {
  const double width = biweight_tuning * deviations_per_median * median_magnitude(offsets.offset);
  std::vector<WeightedSum> sums(surface.sample_count(), WeightedSum::Zero());
  for (std::size_t i = 0; i < offsets.sample.size(); ++i) {
    // Infinite for a point off a surface that most points lie in exactly (width 0).
    const double u = offsets.offset[i] != 0 ? offsets.offset[i] / width : 0;
    if (std::abs(u) >= 1) continue;
    const double weight = cloud.weight(i) * (1 - u * u) * (1 - u * u);
    sums[offsets.sample[i]] += WeightedSum(weight * offsets.offset[i], weight);
  }
  const std::vector<WeightedSum> pulled = surface.to_control<WeightedSum>(sums);
  std::vector<double> moves(pulled.size(), 0.0);
  for (std::size_t v = 0; v < moves.size(); ++v)
    if (pulled[v][1] > 0) moves[v] = pulled[v][0] / pulled[v][1];
  return moves;
}

/// The rim of the surface: its boundary samples and, for each, the samples before and after it along the boundary.
struct Rim {
  std::vector<Index> sample, previous, next;
  std::vector<Index> position;  ///< per sample of the surface: its place in `sample`, or no_index
};

Rim find_rim(const LimitSurface& surface) {
  const HalfEdges he = half_edges(surface.faces(), surface.sample_count());
  Rim rim;
  rim.position.assign(surface.sample_count(), no_index);
  for (const std::vector<Index>& loop : boundary_loops(surface.faces(), he))
    for (std::size_t k = 0; k < loop.size(); ++k) {
      rim.position[loop[k]] = static_cast<Index>(rim.sample.size());
      rim.sample.push_back(loop[k]);
      rim.previous.push_back(loop[(k + loop.size() - 1) % loop.size()]);
      rim.next.push_back(loop[(k + 1) % loop.size()]);
    }
  return rim;
}

/// The rim ends where the means of the outermost Gaussians lie, half a Gaussian short of the points. Moves the control
/// vertices of the rim outward, in the surface, by the width of the strip of points left beyond it: twice the mean
/// distance of those points, but not more than their number fills at the spacing of the cloud, so that strays do not
/// pull it.
void extend_rim(const LimitSurface& surface, const Rim& rim, const SurfaceSamples& samples, const Offsets& offsets,
                const PointCloud& cloud, Mixture& control) {
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
  const double thickness = biweight_tuning * deviations_per_median * median_magnitude(offsets.offset);
  std::vector<WeightedSum> beyond(n, WeightedSum::Zero());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Index k = rim.position[offsets.sample[i]];
    if (k == no_index || std::abs(offsets.offset[i]) > thickness) continue;
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

}  // namespace

void FitOptions::check() const {
  if (steps < 0 || steps > 100) throw OptionError("steps must be in [0, 100], not " + std::to_string(steps));
  if (level < 0 || level > 5) throw OptionError("level must be in [0, 5], not " + std::to_string(level));
}

CovMesh fit(CovMesh mesh, const PointCloud& cloud, const FitOptions& options, const RunContext& context) {
  options.check();
  if (options.steps == 0 || cloud.empty() || mesh.faces.empty()) return mesh;
  const LimitSurface surface(mesh.faces, mesh.vertices.size(), options.level, LoopWeights::loop, CornerRule::smooth,
                             context);
  const Rim rim = find_rim(surface);
  const SampleGraph graph = sample_graph(surface);
  Offsets offsets;
  for (int step = 0; step < options.steps; ++step) {
    const SurfaceSamples samples = surface.evaluate(mesh.vertices, true, context);
    if (step == 0)
      offsets = find_offsets(samples, cloud, context);
    else
      follow_offsets(samples, graph, cloud, context, offsets);
    const std::vector<double> moves = average_offsets(surface, offsets, cloud);
    for (std::size_t v = 0; v < moves.size(); ++v) mesh.vertices.means[v] += moves[v] * samples.normals[v];
    extend_rim(surface, rim, samples, offsets, cloud, mesh.vertices);
    context.progress("fit", static_cast<double>(step + 1) / options.steps);
  }
  return mesh;
}

}  // namespace gpsrecon
