// Noise as the residual of a local quadric (the jet of second order of Cazals and Pouget 2005) over neighbourhoods that
// grow until they show the surface (after Mitra, Nguyen and Guibas 2004).

#include <gpsrecon/core/local_scale.h>

#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/principal_axes.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/core/sheets.h>
#include <gpsrecon/core/sym3.h>
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>

namespace gpsrecon::internal {
namespace {

constexpr std::size_t neighborhood = 64;
constexpr std::size_t small_neighborhood = 24;
/// Each thinning leaves a quarter of the points: the radius of a neighbourhood doubles.
constexpr std::size_t thinning = 4;
constexpr std::size_t most_thinnings = 5;
constexpr std::size_t most_samples = 8192;
/// A quadric through fewer points has no residual to speak of.
constexpr std::size_t fewest_points = 10;

/// A sheet is thin in a ball if its noise is at most this share of the smaller deviation of the points along it, half
/// the radius: the ball then reaches four deviations to either side.
constexpr double thin = 0.45;
/// Its points spread in two directions if those differ by no more than this.
constexpr double slender = 0.25;
/// And it is no layer of a thicker sheet if the points over its middle, in the next larger ball, deviate no more.
constexpr double hidden = 0.6;
constexpr double middle = 0.7;
/// Points without any noise, but for the rounding of files, lie in a layer of rounded depths: larger balls tell.
constexpr double exact = 1e-4;
/// The two sheets of a wall are as far apart in the next larger ball.
constexpr double same_gap = 1.4;

/// Samples around one by which its value is smoothed.
constexpr std::size_t smoothing = 32;
/// Curvature and edges only add to residuals: a low quantile of those around. Times that for the mean of equal ones,
/// which scatter by a tenth.
constexpr double low_quantile = 0.3;
constexpr double of_quantile = 1.05;
/// Walls count where at least one of so many neighbourhoods shows two sheets.
constexpr std::size_t wall_share = 5;

constexpr std::size_t probes = 24;
/// Places are looked at within this many deviations of the middle; the points reach two.
constexpr double inner = 1.5;
/// Smaller spacings than this many noises hardly change a kernel, and at rims places beside the surface count as well.
constexpr double over_noise = 4;
/// Median distance of a place from the nearest of points spread at random with spacing 1: sqrt(ln 2 / π).
const double probe_distance = std::sqrt(std::numbers::ln2 / std::numbers::pi);
/// Places between points count where they say that these are so much sparser than their neighbours are near.
constexpr double clumped = 1.5;

using Terms = Eigen::Matrix<double, 6, 1>;

/// Of a quadric over u, v in [-1, 1], roughly.
Terms terms(double u, double v) {
  return Terms{{1, u, v, u * u, u * v, v * v}};
}

struct Patch {
  Vec3 center = Vec3::Zero(), normal = Vec3::Zero();
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();  ///< directions in the plane
  Terms height = Terms::Zero();                      ///< over u along `first` and v along `second`, in deviations
  double noise = 0;
  double along = 0, across = 0;  ///< largest deviation in the plane, and the one at right angles to it

  Vec3 at(double u, double v) const {
    return center + u * along * first + v * across * second + height.dot(terms(u, v)) * normal;
  }
  /// At most 1 if it shows a thin sheet.
  double thickness() const { return std::max(noise / (thin * across), slender * along / across); }
};

/// Precondition: not empty.
Patch fit_quadric(std::span<const Vec3> points, const std::vector<Neighbor>& near) {
  Patch patch;
  patch.center = points[near.front().index];
  const Eigen3 axes = eigen_decomposition(local_covariance(points, patch.center, near));
  patch.normal = axes.vectors.col(0);
  patch.second = axes.vectors.col(1);
  patch.first = axes.vectors.col(2);
  patch.along = std::sqrt(std::max(0.0, axes.values[2]));
  patch.across = std::sqrt(std::max(0.0, axes.values[1]));
  patch.noise = std::sqrt(std::max(0.0, axes.values[0]));
  if (!(patch.across > 0) || near.size() < fewest_points) return patch;
  Eigen::Matrix<double, 6, 6> normal_matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Terms right = Terms::Zero();
  double squares = 0;
  for (const Neighbor& n : near) {
    const Vec3 d = points[n.index] - patch.center;
    const Terms row = terms(patch.first.dot(d) / patch.along, patch.second.dot(d) / patch.across);
    const double z = patch.normal.dot(d);
    normal_matrix.selfadjointView<Eigen::Lower>().rankUpdate(row);
    right += z * row;
    squares += z * z;
  }
  // Where points in a few rows or clumps leave terms open, these stay small.
  normal_matrix.diagonal() *= 1 + 1e-3;
  patch.height = normal_matrix.selfadjointView<Eigen::Lower>().ldlt().solve(right);
  const double rest = std::max(0.0, squares - patch.height.dot(right));
  patch.noise = std::sqrt(rest / static_cast<double>(near.size() - Terms::SizeAtCompileTime));
  return patch;
}

/// The cloud, or fewer and fewer of its points.
struct Level {
  std::span<const Vec3> points;
  std::span<const Vec3> sensors;  ///< where each was seen from, or empty
  const Neighbors* index;
  std::size_t size;  ///< of a neighbourhood
};

/// Mean cosine of the angle between the normal and the way from those points to where they were seen from.
double seen_side(const Level& level, const Vec3& normal, const std::vector<Neighbor>& near) {
  double sum = 0;
  for (const Neighbor& n : near) {
    const Vec3 way = level.sensors[n.index] - level.points[n.index];
    if (way.allFinite()) sum += normal.dot(way.stableNormalized());
  }
  return sum / static_cast<double>(near.size());
}

/// keep_one_sheet(), where the two were not seen from the same side: of such, the nearer would hide the other. Depths
/// that a sensor rounds lie in layers. `both` is for work.
double keep_one_surface(const Level& level, const Vec3& normal, std::vector<Neighbor>& near,
                        std::vector<Neighbor>& both) {
  both = near;
  const double gap = keep_one_sheet(level.points, normal, near);
  if (gap == 0 || level.sensors.empty()) return gap;
  const auto n = static_cast<double>(near.size()), all = static_cast<double>(both.size());
  const double kept = seen_side(level, normal, near);
  const double dropped = (all * seen_side(level, normal, both) - n * kept) / (all - n);
  if (std::min(std::abs(kept), std::abs(dropped)) < least_view || kept * dropped < 0) return gap;
  near = both;
  return 0;
}

/// Deviation along the normal of the patch of those points `near` that lie over its middle, without another sheet
/// clear of this one; 0 if there are hardly any.
double deviation_over_middle(const Patch& patch, const Level& level, const std::vector<Neighbor>& near,
                             std::vector<Neighbor>& over, std::vector<Neighbor>& both) {
  const std::span<const Vec3> points = level.points;
  const double radius = middle * 2 * patch.across;
  over.clear();
  for (const Neighbor& n : near) {
    const Vec3 d = points[n.index] - patch.center;
    const double z = patch.normal.dot(d);
    if (d.squaredNorm() - z * z <= radius * radius) over.push_back(n);
  }
  if (over.size() < 3) return 0;
  keep_one_surface(level, patch.normal, over, both);
  double sum = 0, squares = 0;
  for (const Neighbor& n : over) {
    const double z = patch.normal.dot(points[n.index] - patch.center);
    sum += z;
    squares += z * z;
  }
  const auto count = static_cast<double>(over.size());
  return count < 2 ? 0 : std::sqrt(std::max(0.0, (squares - sum * sum / count) / (count - 1)));
}

class Pyramid {
 public:
  Pyramid(std::span<const Vec3> points, std::span<const Vec3> sensors, const Neighbors& index) {
    levels_.push_back({points, sensors, &index, small_neighborhood});
    levels_.push_back({points, sensors, &index, neighborhood});
    for (std::size_t step = thinning; points.size() >= 4 * neighborhood * step && sets_.size() < most_thinnings;
         step *= thinning) {
      // One of every `step` points, which are neighbours in space, drawn at random.
      Set& set = *sets_.emplace_back(std::make_unique<Set>());
      for (std::size_t i = 0; i + step <= points.size(); i += step) {
        const std::size_t k = i + static_cast<std::size_t>(random_uniform(0, step, i) * static_cast<double>(step));
        set.points.push_back(points[k]);
        if (!sensors.empty()) set.sensors.push_back(sensors[k]);
      }
      set.index.emplace(set.points);
      levels_.push_back({set.points, set.sensors, &*set.index, neighborhood});
    }
  }
  const std::vector<Level>& levels() const { return levels_; }

 private:
  struct Set {
    std::vector<Vec3> points, sensors;
    std::optional<Neighbors> index;
  };
  std::vector<std::unique_ptr<Set>> sets_;
  std::vector<Level> levels_;
};

/// What the neighbourhoods of one point tell.
struct Sample {
  double noise = 0;
  double spacing = 0;
  bool certain = false;     ///< a neighbourhood showed the surface
  bool two_sheets = false;  ///< of a wall; the noise is that of one
};

struct Workspace {
  std::vector<Neighbor> near, one_sheet, nearest;
  std::vector<Patch> patches;
};

/// Median distance from the nearest point of the cloud of places spread over the patch.
double distance_to_points(const Patch& patch, const Neighbors& index, std::size_t stream,
                          std::vector<Neighbor>& nearest) {
  std::array<double, probes> distance;
  for (std::size_t k = 0; k < probes; ++k) {
    const double radius = inner * patch.across * std::sqrt(random_uniform(stream, 0, k));
    const double angle = 2 * std::numbers::pi * random_uniform(stream, 1, k);
    const double u = patch.along > 0 ? radius * std::cos(angle) / patch.along : 0;
    const double v = patch.across > 0 ? radius * std::sin(angle) / patch.across : 0;
    index.nearest(patch.at(u, v), 1, nearest);
    distance[k] = nearest.front().distance;
  }
  return median(distance);
}

Sample measure(const Pyramid& pyramid, const Vec3& at, std::size_t number, Workspace& work) {
  const std::vector<Level>& levels = pyramid.levels();
  Sample sample;
  Patch chosen;
  double least = std::numeric_limits<double>::infinity(), gap_before = 0;
  Patch sheet_before;
  work.patches.clear();
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const Level& level = levels[l];
    level.index->nearest(at, level.size, work.near);
    work.patches.push_back(fit_quadric(level.points, work.near));
    const Patch& patch = work.patches.back();
    work.one_sheet = work.near;
    const double gap = keep_one_surface(level, patch.normal, work.one_sheet, work.nearest);
    if (gap > 0 && gap_before > 0 && gap < same_gap * gap_before && gap_before < same_gap * gap) {
      chosen = sheet_before;
      sample.certain = sample.two_sheets = true;
      break;
    }
    gap_before = 0;
    if (gap > 0) {
      sheet_before = fit_quadric(level.points, work.one_sheet);
      // Two heaps of a few clumps or lines are no sheets.
      if (sheet_before.across > 0.5 * patch.across) gap_before = gap;
    }
    // Judged by a ball of twice the radius. Of the two sizes of the whole cloud the larger is not yet one.
    for (std::size_t smaller = l == 2 ? 0 : l - 1; l >= 1 && smaller < l && !sample.certain; ++smaller) {
      if (l == 1 && levels.size() > 2) break;
      const Patch& judged = work.patches[smaller];
      sample.certain =
          judged.noise > exact * judged.across && judged.thickness() <= 1 &&
          deviation_over_middle(judged, level, work.near, work.nearest, work.one_sheet) <= hidden * judged.across;
      // Where none shows a surface, as on clutter, the smallest one that looks thin.
      if (sample.certain || (least > 1 && judged.thickness() < least)) chosen = judged;
      least = std::min(least, judged.thickness());
    }
    if (sample.certain) break;
  }
  if (!(chosen.along > 0)) chosen = work.patches.back();
  sample.noise = chosen.noise;
  sample.spacing = distance_to_points(chosen, *levels.front().index, number, work.nearest) / probe_distance;
  return sample;
}

struct Smooth {
  double spacing = 0;
  double noise = -1;  ///< negative where it is unknown
};

Smooth smooth(const std::vector<Sample>& samples, const std::vector<Neighbor>& near) {
  std::vector<double> spacing, noise, of_sheets;
  for (const Neighbor& n : near) {
    const Sample& sample = samples[n.index];
    spacing.push_back(sample.spacing);
    if (sample.certain) noise.push_back(sample.noise);
    if (sample.two_sheets) of_sheets.push_back(sample.noise);
  }
  Smooth result;
  result.spacing = median(spacing);
  std::vector<double>& known = wall_share * of_sheets.size() >= near.size() ? of_sheets : noise;
  if (&known == &of_sheets || 2 * known.size() >= near.size())
    result.noise =
        of_quantile * value_of_rank(known, static_cast<std::size_t>(low_quantile * static_cast<double>(known.size())));
  return result;
}

}  // namespace

LocalScale estimate_local_scale(std::span<const Vec3> points, std::span<const Vec3> sensors, const Neighbors& index,
                                std::span<const double> by_neighbors, const RunContext& context) {
  const std::size_t n = points.size();
  const Pyramid pyramid(points, sensors, index);
  const std::size_t stride = std::max<std::size_t>(1, n / most_samples), count = (n + stride - 1) / stride;
  std::vector<Vec3> at(count);
  for (std::size_t s = 0; s < count; ++s) at[s] = points[s * stride];
  std::vector<Sample> samples(count);
  constexpr std::size_t block = 128;
  parallel_blocks(
      count, context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        Workspace work;
        for (std::size_t s = begin; s < end; ++s) {
          samples[s] = measure(pyramid, at[s], s, work);
          const double usual = by_neighbors[s * stride];
          if (samples[s].spacing < std::max(clumped * usual, over_noise * samples[s].noise)) samples[s].spacing = usual;
        }
      },
      block);

  const Neighbors places(at);
  std::vector<Smooth> smoothed(count);
  parallel_blocks(
      count, context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t s = begin; s < end; ++s) {
          places.nearest(at[s], smoothing, near);
          smoothed[s] = smooth(samples, near);
        }
      },
      block);
  // Where nothing is known, what is usual elsewhere; and if nothing is known anywhere, what there is.
  std::vector<double> known;
  for (const Smooth& s : smoothed)
    if (s.noise >= 0) known.push_back(s.noise);
  if (4 * known.size() < count) {
    known.clear();
    for (const Sample& s : samples) known.push_back(s.noise);
  }
  const double usual = median(known);
  for (Smooth& s : smoothed)
    if (s.noise < 0) s.noise = usual;

  LocalScale scale{std::vector<double>(n), std::vector<double>(n)};
  parallel_blocks(n, context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> near;
    for (std::size_t i = begin; i < end; ++i) {
      places.nearest(points[i], stride == 1 ? 1 : 4, near);
      double total = 0;
      for (const Neighbor& p : near) {
        const Smooth& s = smoothed[p.index];
        const double weight =
            1 / (p.distance * p.distance + 1e-6 * s.spacing * s.spacing + std::numeric_limits<double>::min());
        total += weight;
        scale.spacing[i] += weight * s.spacing;
        scale.noise[i] += weight * s.noise;
      }
      scale.spacing[i] /= total;
      scale.noise[i] /= total;
    }
  });
  return scale;
}

}  // namespace gpsrecon::internal
