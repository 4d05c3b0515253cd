#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/sym3.h>
#include <gpsrecon/hem/scale.h>
#include <algorithm>
#include <numbers>

namespace gpsrecon {
namespace {

constexpr std::size_t spacing_neighbors = 8;  // without the point itself
constexpr std::size_t noise_neighbors = 48;   // with the point itself
// Points around a sparse one lie in a sheet if their smallest deviation is below this share of the middle one.
constexpr double sheet_flatness = 0.4;
// A median needs no more places than this.
constexpr std::size_t noise_samples = 16384;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> neighbor_distances(const std::vector<Vec3>& points, const Neighbors& index, std::size_t k,
                                       const RunContext& context) {
  std::vector<double> distances(points.size());
  parallel_blocks(points.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> found;
    for (std::size_t i = begin; i < end; ++i) {
      index.nearest(points[i], k + 1, found);
      distances[i] = found.back().distance;
    }
  });
  return distances;
}

Eigen3 principal_axes(const std::vector<Vec3>& points, const Vec3& center, const std::vector<Neighbor>& near) {
  Vec3 mean = Vec3::Zero();
  for (const Neighbor& n : near) mean += points[n.index] - center;
  mean /= static_cast<double>(near.size());
  Sym3 covariance;
  for (const Neighbor& n : near) covariance += Sym3::outer(points[n.index] - center - mean);
  return eigen_decomposition(covariance * (1.0 / static_cast<double>(near.size())));
}

/// A point far from its neighbours may lie where the surface was sampled thinly: then its neighbours are as far from
/// theirs, and all lie in a sheet.
bool in_sparse_sheet(const std::vector<Vec3>& points, const Neighbors& index, const std::vector<double>& distances,
                     std::size_t i) {
  std::vector<Neighbor> near;
  index.nearest(points[i], 2 * spacing_neighbors, near);
  std::vector<double> around;
  for (const Neighbor& n : near) around.push_back(distances[n.index]);
  if (distances[i] > 2 * median(std::move(around))) return false;
  const Vec3 variance = principal_axes(points, points[i], near).values;
  return variance[0] < sheet_flatness * sheet_flatness * variance[1];
}

/// Smallest principal standard deviation of the points around each of a regular subset of the points.
std::vector<double> thicknesses(const std::vector<Vec3>& points, const Neighbors& index, const RunContext& context) {
  const std::size_t stride = std::max<std::size_t>(1, points.size() / noise_samples);
  std::vector<double> thickness((points.size() + stride - 1) / stride);
  parallel_blocks(
      thickness.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> found;
        for (std::size_t s = begin; s < end; ++s) {
          const Vec3& center = points[s * stride];
          index.nearest(center, noise_neighbors, found);
          thickness[s] = std::sqrt(std::max(0.0, principal_axes(points, center, found).values[0]));
        }
      },
      512);
  return thickness;
}

}  // namespace

void ScaleOptions::check() const {
  if (!(isolation == 0 || isolation > 1) || !std::isfinite(isolation))
    throw OptionError("isolation must be 0 or greater than 1, not " + std::to_string(isolation));
}

Scale estimate_scale(const PointCloud& cloud, const ScaleOptions& options, const RunContext& context) {
  options.check();
  const std::size_t n = cloud.size();
  if (n < 3) throw NoSurfaceError("no surface through " + std::to_string(n) + " distinct points");
  const Neighbors index(cloud.positions);
  const std::size_t k = std::min(spacing_neighbors, n - 1);
  const std::vector<double> distances = neighbor_distances(cloud.positions, index, k, context);
  context.progress("scale", 0.6);

  Scale scale;
  const double typical = median(distances);
  // A disc of the distance to the k-th neighbour holds k + 1 points.
  scale.spacing = typical * std::sqrt(std::numbers::pi / static_cast<double>(k + 1));
  scale.noise = median(thicknesses(cloud.positions, index, context));
  scale.sigma0 = std::hypot(scale.spacing, scale.noise);
  scale.sigma0_local = std::hypot(0.4 * scale.spacing, 1.6 * scale.noise);
  if (options.isolation > 0)
    for (std::size_t i = 0; i < n; ++i)
      if (distances[i] > options.isolation * typical && !in_sparse_sheet(cloud.positions, index, distances, i))
        scale.isolated.push_back(static_cast<Index>(i));
  context.progress("scale", 1);
  return scale;
}

}  // namespace gpsrecon
