#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/fit/fit.h>
#include <gpsrecon/gps/limit_surface.h>
#include <algorithm>
#include <cmath>
#include <string>

namespace gpsrecon {
namespace {

/// Tuning constant of Tukey's biweight (95 % efficient on normal noise), in robust standard deviations.
constexpr double biweight_tuning = 4.685;
constexpr double deviations_per_median = 1.4826;

/// Signed normal offset of every point from the surface sample closest to it.
struct Offsets {
  std::vector<Index> sample;
  std::vector<double> offset;
};

Offsets measure(const SurfaceSamples& samples, const PointCloud& cloud, const RunContext& context) {
  const Neighbors index(samples.positions);
  Offsets offsets{std::vector<Index>(cloud.size()), std::vector<double>(cloud.size())};
  parallel_blocks(cloud.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> found;
    for (std::size_t i = begin; i < end; ++i) {
      index.nearest(cloud.positions[i], 1, found);
      const Index s = found.front().index;
      offsets.sample[i] = s;
      offsets.offset[i] = samples.normals[s].dot(cloud.positions[i] - samples.positions[s]);
    }
  });
  return offsets;
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
  for (int step = 0; step < options.steps; ++step) {
    const SurfaceSamples samples = surface.evaluate(mesh.vertices, true, context);
    const std::vector<double> moves = average_offsets(surface, measure(samples, cloud, context), cloud);
    for (std::size_t v = 0; v < moves.size(); ++v) mesh.vertices.means[v] += moves[v] * samples.normals[v];
    context.progress("fit", static_cast<double>(step + 1) / options.steps);
  }
  return mesh;
}

}  // namespace gpsrecon
