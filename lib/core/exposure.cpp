// Absorption along rays: Max 1995, "Optical models for direct volume rendering", absorption only, averaged over
// directions.

#include <gpsrecon/core/exposure.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace gpsrecon::internal {
namespace {

constexpr int view_count = 32;                     // lines; light comes from both ends
constexpr double optical_depth = 3;                // of a sheet at right angles
constexpr double cutoff2 = 2.5 * 2.5;              // squared Mahalanobis distance beside a ray that still counts
constexpr double rounding = 1e-12;                 // of a variance that is left when the rest is taken off
constexpr std::size_t neighbors_for_density = 16;  // beyond the second ring of even coverings

/// Axes of a parallel projection.
struct View {
  Vec3 right, up, toward;
  explicit View(const Vec3& direction)
      : right(direction.unitOrthogonal()), up(direction.cross(right)), toward(direction) {}
};

/// Directions on a half sphere along a spiral of the golden angle.
View view_number(int v) {
  const double z = (v + 0.5) / view_count, angle = v * std::numbers::pi * (3 - std::sqrt(5.0));
  const double r = std::sqrt(1 - z * z);
  return View({r * std::cos(angle), r * std::sin(angle), z});
}

/// A weighted Gaussian in a view: its marginal density over the image, and that along the ray at a point of the image.
struct Splat {
  double x, y, depth;        // of the mean
  double pxx, pxy, pyy;      // precision of the marginal
  double slope_x, slope_y;   // of the mean depth over the image
  double inverse_deviation;  // of the depth given that point
  double peak;               // of the weighted marginal

  Splat() = default;
  Splat(const View& view, const Vec3& mean, const Sym3& covariance, double weight)
      : x(view.right.dot(mean)), y(view.up.dot(mean)), depth(view.toward.dot(mean)) {
    const Vec3 right = covariance * view.right, up = covariance * view.up, toward = covariance * view.toward;
    const double xx = view.right.dot(right), xy = view.right.dot(up), yy = view.up.dot(up);
    const double determinant = std::max(xx * yy - xy * xy, rounding * xx * yy);
    pxx = yy / determinant, pxy = -xy / determinant, pyy = xx / determinant;
    const double xz = view.right.dot(toward), yz = view.up.dot(toward), zz = view.toward.dot(toward);
    slope_x = pxx * xz + pxy * yz, slope_y = pxy * xz + pyy * yz;
    inverse_deviation = 1 / std::sqrt(std::max(zz - slope_x * xz - slope_y * yz, rounding * zz));
    peak = weight / (2 * std::numbers::pi * std::sqrt(determinant));
  }

  double squared_distance(double dx, double dy) const { return pxx * dx * dx + 2 * pxy * dx * dy + pyy * dy * dy; }
  /// Half the sides of the box around where squared_distance is at most cutoff2.
  double half_width() const { return std::sqrt(cutoff2 * pyy / (pxx * pyy - pxy * pxy)); }
  double half_height() const { return std::sqrt(cutoff2 * pxx / (pxx * pyy - pxy * pxy)); }
};

/// Lists, per cell of an image, of the splats whose boxes touch it.
class SplatGrid {
 public:
  explicit SplatGrid(const std::vector<Splat>& splats) {
    double squares = 0, right = -std::numeric_limits<double>::infinity(), top = right;
    left_ = bottom_ = -right;
    for (const Splat& s : splats) {
      const double width = s.half_width(), height = s.half_height();
      squares += width * height;
      left_ = std::min(left_, s.x), right = std::max(right, s.x);
      bottom_ = std::min(bottom_, s.y), top = std::max(top, s.y);
    }
    // Cells as large as the boxes are on average, in area, keep the lists linear in the number of splats; and there are
    // no more than a few cells per splat.
    const double n = static_cast<double>(splats.size());
    cell_ = std::max({std::sqrt(squares / n), std::sqrt((right - left_) * (top - bottom_) / (4 * n)),
                      (right - left_) / (4 * n), (top - bottom_) / (4 * n)});
    columns_ = static_cast<std::size_t>((right - left_) / cell_) + 1;
    rows_ = static_cast<std::size_t>((top - bottom_) / cell_) + 1;
    start_.assign(columns_ * rows_ + 1, 0);
    for_each_entry(splats, [&](std::size_t cell, Index) { ++start_[cell + 1]; });
    for (std::size_t c = 0; c + 1 < start_.size(); ++c) start_[c + 1] += start_[c];
    entries_.resize(start_.back());
    std::vector<std::size_t> cursor(start_.begin(), start_.end() - 1);
    for_each_entry(splats, [&](std::size_t cell, Index i) { entries_[cursor[cell]++] = i; });
  }

  std::span<const Index> near(double x, double y) const {
    const std::size_t cell = row(y) * columns_ + column(x);
    return {entries_.data() + start_[cell], entries_.data() + start_[cell + 1]};
  }

 private:
  std::size_t column(double x) const { return cell_along(x - left_, columns_); }
  std::size_t row(double y) const { return cell_along(y - bottom_, rows_); }
  std::size_t cell_along(double offset, std::size_t count) const {
    return static_cast<std::size_t>(std::clamp(offset / cell_, 0.0, static_cast<double>(count - 1)));
  }
  template <class Visit>
  void for_each_entry(const std::vector<Splat>& splats, const Visit& visit) const {
    for (Index i = 0; i < splats.size(); ++i) {
      const Splat& s = splats[i];
      const double width = s.half_width(), height = s.half_height();
      const std::size_t last_row = row(s.y + height), last_column = column(s.x + width);
      for (std::size_t r = row(s.y - height); r <= last_row; ++r)
        for (std::size_t c = column(s.x - width); c <= last_column; ++c) visit(r * columns_ + c, i);
    }
  }

  double left_, bottom_, cell_ = 0;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<std::size_t> start_;
  std::vector<Index> entries_;
};

/// Weights under which the components of one sheet, seen at right angles, add up to a density of 1 everywhere.
std::vector<double> even_weights(const Mixture& mixture, const std::vector<Vec3>& axis, const RunContext& context) {
  const Neighbors index(mixture.means);
  std::vector<double> weights(mixture.size());
  parallel_blocks(
      mixture.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t i = begin; i < end; ++i) {
          const View view(axis[i]);
          const double x = view.right.dot(mixture.means[i]), y = view.up.dot(mixture.means[i]);
          const double depth = view.toward.dot(mixture.means[i]);
          index.nearest(mixture.means[i], neighbors_for_density, near);
          double density = 0;
          for (const Neighbor& n : near) {
            const Splat s(view, mixture.means[n.index], mixture.covariances[n.index], mixture.weights[n.index]);
            const double dx = x - s.x, dy = y - s.y;
            // Other sheets close by count the less the farther they are off, in deviations of two of their thickness.
            const double off = (depth - s.depth - s.slope_x * dx - s.slope_y * dy) * s.inverse_deviation;
            density += s.peak * std::exp(-0.5 * (s.squared_distance(dx, dy) + 0.5 * off * off));
          }
          weights[i] = mixture.weights[i] / density;
        }
      },
      256);
  return weights;
}

}  // namespace

Exposure exposure(const Mixture& mixture, const RunContext& context) {
  const std::size_t n = mixture.size();
  Exposure result{std::vector<Vec3>(n), std::vector<double>(n, 0), std::vector<double>(n, 0),
                  std::vector<Vec3>(n, Vec3::Zero())};
  if (n == 0) return result;
  parallel_for(n, context,
               [&](std::size_t i) { result.axis[i] = eigen_decomposition(mixture.covariances[i]).vectors.col(0); });
  const std::vector<double> weights = even_weights(mixture, result.axis, context);
  std::vector<Splat> splats(n);
  std::vector<double> unshaded(n, 0);  // light on either side, if there were no others
  for (int v = 0; v < view_count; ++v) {
    const View view = view_number(v);
    parallel_for(n, context,
                 [&](std::size_t i) { splats[i] = Splat(view, mixture.means[i], mixture.covariances[i], weights[i]); });
    const SplatGrid grid(splats);
    parallel_for(
        n, context,
        [&](std::size_t i) {
          const Splat& own = splats[i];
          double before = 0, behind = 0;  // density along the ray, towards the viewer and away
          for (const Index j : grid.near(own.x, own.y)) {
            const Splat& s = splats[j];
            const double dx = own.x - s.x, dy = own.y - s.y, q = s.squared_distance(dx, dy);
            if (q > cutoff2 || j == i) continue;
            const double off = (s.depth + s.slope_x * dx + s.slope_y * dy - own.depth) * s.inverse_deviation;
            const double density = s.peak * std::exp(-0.5 * q);
            const double share = 0.5 * std::erfc(-off / std::numbers::sqrt2);
            before += density * share;
            behind += density * (1 - share);
          }
          const double toward = std::exp(-optical_depth * before), away = std::exp(-optical_depth * behind);
          const double cosine = result.axis[i].dot(view.toward);
          unshaded[i] += std::abs(cosine);
          result.front[i] += std::abs(cosine) * (cosine > 0 ? toward : away);
          result.back[i] += std::abs(cosine) * (cosine > 0 ? away : toward);
          result.bent_normal[i] += (toward - away) * view.toward;
        },
        256);
  }
  for (std::size_t i = 0; i < n; ++i) {
    result.front[i] /= unshaded[i];
    result.back[i] /= unshaded[i];
    result.bent_normal[i] /= view_count;
  }
  return result;
}

}  // namespace gpsrecon::internal
