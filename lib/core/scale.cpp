// Noise from the smallest principal deviation (Hoppe et al. 1992); two sheets told apart by Otsu's threshold (Otsu
// 1979).

#include <gpsrecon/core/scale.h>

#include <gpsrecon/core/estimate_scale.h>
#include <gpsrecon/core/local_scale.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/principal_axes.h>
#include <gpsrecon/core/sheets.h>
#include <gpsrecon/core/sym3.h>
#include <algorithm>
#include <numbers>
#include <numeric>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr std::size_t spacing_neighbors = 8;  // without the point itself
constexpr std::size_t noise_neighbors = 48;   // with the point itself
// Points around a sparse one lie in a sheet if their smallest deviation is below this share of the middle one.
constexpr double sheet_flatness = 0.4;
// A median needs no more neighbourhoods than this.
constexpr std::size_t noise_samples = 16384;

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

/// A point far from its neighbours may lie where the surface was sampled thinly: then its neighbours are as far from
/// theirs, and all lie in a sheet.
bool in_sparse_sheet(const std::vector<Vec3>& points, const Neighbors& index, const std::vector<double>& distances,
                     std::size_t i) {
  std::vector<Neighbor> near;
  index.nearest(points[i], 2 * spacing_neighbors, near);
  std::vector<double> around;
  around.reserve(near.size());
  for (const Neighbor& n : near) around.push_back(distances[n.index]);
  if (distances[i] > 2 * median(around)) return false;
  const Vec3 variance = eigen_decomposition(local_covariance(points, points[i], near)).values;
  return variance[0] < sheet_flatness * sheet_flatness * variance[1];
}

/// Walls count where at least this share of the neighbourhoods shows two sheets. Fewer hardly move a median; and where
/// scans overlap badly, or depths come in steps, one surface shows as two here and there.
constexpr double least_walls = 0.2;

double smallest_deviation(const Eigen3& axes) {
  return std::sqrt(std::max(0.0, axes.values[0]));
}

/// The noise: smallest principal standard deviation of the points around each of a regular subset of the points,
/// median. In a cloud of thin walls, over the neighbourhoods whose two sheets can be told apart, of the points of one.
void estimate_noise(const std::vector<Vec3>& points, const Neighbors& index, const RunContext& context, Scale& scale) {
  const std::size_t stride = std::max<std::size_t>(1, points.size() / noise_samples);
  std::vector<double> thickness((points.size() + stride - 1) / stride);
  std::vector<double> of_one_sheet(thickness.size(), -1);  // where there are two
  parallel_blocks(
      thickness.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> found;
        for (std::size_t s = begin; s < end; ++s) {
          const Vec3& center = points[s * stride];
          index.nearest(center, noise_neighbors, found);
          const Eigen3 axes = eigen_decomposition(local_covariance(points, center, found));
          thickness[s] = smallest_deviation(axes);
          if (keep_one_sheet(points, axes.vectors.col(0), found) > 0)
            of_one_sheet[s] = smallest_deviation(eigen_decomposition(local_covariance(points, center, found)));
        }
      },
      512);
  std::erase_if(of_one_sheet, [](double t) { return t < 0; });
  const double walls = static_cast<double>(of_one_sheet.size()) / static_cast<double>(thickness.size());
  scale.thin_walls = walls >= least_walls;
  scale.noise = median(scale.thin_walls ? of_one_sheet : thickness);
}

/// Logarithm of the ratio of two estimates of one length that may be chance; twice that is not.
constexpr double chance = 0.3;

/// A ratio of two estimates, as far as it is not chance.
double beyond_chance(double ratio) {
  const double x = std::log(ratio);
  return std::exp(x * std::clamp((std::abs(x) - chance) / chance, 0.0, 1.0));
}

/// Lengths at the points become multiples of that of the whole cloud, and that one follows their median.
void reconcile(double& whole, std::vector<double>& at) {
  std::vector<double> values = at;
  const double usual = median(values);
  if (!(usual > 0) || !(whole > 0)) {
    whole = usual;
    return;
  }
  whole *= beyond_chance(usual / whole);
  for (double& x : at) x = whole * beyond_chance(x / usual);
}

}  // namespace

bool internal::differs_by_point(const Scale& scale) {
  const auto differ = [](const std::vector<double>& at, double whole) {
    return std::any_of(at.begin(), at.end(), [whole](double x) { return x != whole; });
  };
  return differ(scale.spacing_at, scale.spacing) || differ(scale.noise_at, scale.noise);
}

Scale estimate_scale(const PointCloud& cloud, const ScaleOptions& options, const RunContext& context) {
  return estimate_scale(cloud, Neighbors(cloud.positions), options, context);
}

Scale internal::estimate_scale(const PointCloud& cloud, const Neighbors& index, const ScaleOptions& options,
                               const RunContext& context) {
  options.check();
  const std::size_t n = cloud.size();
  if (n < 3) throw NoSurfaceError("no surface through " + count_of(n, "distinct point"));
  const std::size_t k = std::min(spacing_neighbors, n - 1);
  const std::vector<double> distances = neighbor_distances(cloud.positions, index, k, context);
  context.progress("scale", 0.6);

  Scale scale;
  std::vector<double> reordered = distances;
  const double typical = median(reordered);
  // A disc of the distance to the k-th neighbour holds k + 1 points.
  const double disc = std::sqrt(std::numbers::pi / static_cast<double>(k + 1));
  scale.spacing = typical * disc;
  estimate_noise(cloud.positions, index, context, scale);
  scale.thickness = scale.noise;
  std::vector<double> by_neighbors = distances;
  for (double& spacing : by_neighbors) spacing *= disc;
  LocalScale local = estimate_local_scale(cloud.positions, cloud.sensors, index, by_neighbors, context);
  reconcile(scale.spacing, local.spacing);
  reconcile(scale.noise, local.noise);
  scale.spacing_at = std::move(local.spacing);
  scale.noise_at = std::move(local.noise);
  scale.sigma0 = isotropic_width(scale.spacing, scale.noise);
  scale.sigma0_local = local_width(scale.spacing, scale.noise);
  if (options.isolation > 0)
    for (std::size_t i = 0; i < n; ++i)
      if (by_neighbors[i] > options.isolation * scale.spacing_at[i] &&
          !in_sparse_sheet(cloud.positions, index, distances, i))
        scale.isolated.push_back(static_cast<Index>(i));
  context.progress("scale", 1);
  return scale;
}

}  // namespace gpsrecon
