// Normal deviates: Box & Muller 1958.

#include "virtual_scan.h"

#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>

namespace gpsrecon::internal {
namespace {

/// What random numbers are drawn for; each purpose has a stream of its own.
enum Stream : std::uint64_t {
  image_offset,
  range_noise,
  shift,
  rotation,
  outlier_choice,
  outlier_place,
  spike_length,
  bias_waves
};

using Vec2 = Eigen::Vector2d;

/// One camera, with the error of its registration.
struct View {
  Vec3 sensor;
  Vec3 forward, right, up;
  Vec2 offset;  ///< start of its sequence of image points
  Mat3 rotation_error;
  Vec3 center, shift_error;
  Vec2 bias_frequency, bias_phase;  ///< per direction of the image

  Vec3 registered(const Vec3& p) const { return center + rotation_error * (p - center) + shift_error; }
  /// Of the measured distance, in [-1, 1].
  double bias(const Vec2& image) const {
    return std::sin(bias_frequency.x() * image.x() + bias_phase.x()) *
           std::cos(bias_frequency.y() * image.y() + bias_phase.y());
  }
};

struct Hit {
  Vec3 point, normal, direction;
  Vec2 image;
  Index view;
  std::uint64_t ray;  ///< number of the ray within the view
};

/// Standard normal, by Box and Muller's transform: unlike std::normal_distribution the same with every library.
double random_normal(std::uint64_t seed, Stream stream, std::uint64_t counter) {
  const double u = 1 - random_uniform(seed, stream, 2 * counter);  // in (0, 1]
  const double v = random_uniform(seed, stream, 2 * counter + 1);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

Vec3 random_normal_vector(std::uint64_t seed, Stream stream, std::uint64_t counter) {
  return {random_normal(seed, stream, 3 * counter), random_normal(seed, stream, 3 * counter + 1),
          random_normal(seed, stream, 3 * counter + 2)};
}

/// Number of a ray over all views, as counter of its random numbers.
std::uint64_t ray_counter(const Hit& hit) {
  return (std::uint64_t{hit.view} << 40) + hit.ray;
}

/// As a share of the diagonal of the surface.
double share_of(const Length& length, const ScanTarget& target) {
  return length.resolve({.diagonal = 1, .scene_to_local = 1 / target.diagonal()}, "scan");
}

/// Cameras on a Fibonacci lattice of the sphere.
std::vector<View> place_views(const ScanTarget& target, const ScanOptions& options, std::uint64_t seed) {
  const double shift_deviation = share_of(options.registration_shift, target) * target.diagonal();
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<View> views(static_cast<std::size_t>(options.views));
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double z = 1 - (2 * static_cast<double>(v) + 1) / options.views;
    const double rho = std::sqrt(1 - z * z), phi = golden_angle * static_cast<double>(v);
    const Vec3 outward(rho * std::cos(phi), rho * std::sin(phi), z);
    View& view = views[v];
    view.center = target.center();
    view.sensor = view.center + options.distance * target.bounding_radius() * outward;
    view.forward = -outward;
    view.right = outward.unitOrthogonal();
    view.up = view.right.cross(view.forward);
    view.offset = {random_uniform(seed, image_offset, 2 * v), random_uniform(seed, image_offset, 2 * v + 1)};
    view.shift_error = shift_deviation * random_normal_vector(seed, shift, v);
    const Vec3 turn = radians(options.registration_angle) * random_normal_vector(seed, rotation, v);
    view.rotation_error =
        turn.isZero(0) ? Mat3(Mat3::Identity()) : Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    for (int k = 0; k < 2; ++k) {
      const auto counter = 4 * v + 2 * static_cast<std::size_t>(k);
      // Two to five waves over the width of the image, which is 2.
      view.bias_frequency[k] = std::numbers::pi * (2 + 3 * random_uniform(seed, bias_waves, counter));
      view.bias_phase[k] = 2 * std::numbers::pi * random_uniform(seed, bias_waves, counter + 1);
    }
  }
  return views;
}

/// Image point number `ray` of a view, in [-1, 1)²: the two-dimensional golden-ratio sequence (multiples, modulo 1, of
/// the inverse powers of the root of x³ = x + 1), every prefix of which covers the image evenly.
Vec2 image_point(const View& view, std::uint64_t ray) {
  constexpr double plastic = 1.32471795724474602596;
  const auto image = [&](double offset, double step) {
    const double x = offset + static_cast<double>(ray) * step;
    return 2 * (x - std::floor(x)) - 1;
  };
  return {image(view.offset.x(), 1 / plastic), image(view.offset.y(), 1 / (plastic * plastic))};
}

/// The first `options.points` rays, taking one of each view in turn, that give a point.
std::vector<Hit> trace_views(const ScanTarget& target, const std::vector<View>& views, const ScanOptions& options,
                             const RunContext& context) {
  const double half_width = 1 / std::sqrt(options.distance * options.distance - 1);  // tangent of the cone's half angle
  const double min_cosine = std::cos(radians(options.max_incidence));
  // Rays are traced in rounds until there are enough hits. The size of a round is no part of the result.
  const std::uint64_t round = std::max<std::size_t>(64, options.points / views.size() / 2);
  std::vector<Hit> hits;
  hits.reserve(options.points);
  std::vector<std::optional<Hit>> slots(round * views.size());
  for (std::uint64_t first = 0; hits.size() < options.points; first += round) {
    parallel_for(
        slots.size(), context,
        [&](std::size_t slot) {
          const std::uint64_t ray = first + slot / views.size();
          const std::size_t v = slot % views.size();
          const View& view = views[v];
          const Vec2 image = image_point(view, ray);
          const Vec3 direction =
              (view.forward + half_width * (image.x() * view.right + image.y() * view.up)).normalized();
          slots[slot].reset();
          std::optional<SurfaceHit> q = target.first_hit(view.sensor, direction);
          if (!q) return;
          if (options.both_sides && direction.dot(q->normal) > 0) q->normal = -q->normal;
          if (-direction.dot(q->normal) >= min_cosine)
            slots[slot] = Hit{q->point, q->normal, direction, image, static_cast<Index>(v), ray};
        },
        512);
    const std::size_t before = hits.size();
    for (const std::optional<Hit>& slot : slots)
      if (slot && hits.size() < options.points) hits.push_back(*slot);
    if (hits.size() == before)
      throw NoSurfaceError("no ray of the virtual scan meets the surface at a sufficient angle");
    context.progress("scan", static_cast<double>(hits.size()) / static_cast<double>(options.points));
  }
  return hits;
}

/// `count` of the numbers below n in random order, all choices equally likely.
std::vector<Index> choose(std::size_t count, std::size_t n, std::uint64_t seed) {
  std::vector<std::pair<std::uint64_t, Index>> lots(n);
  for (std::size_t i = 0; i < n; ++i) lots[i] = {random_bits(seed, outlier_choice, i), static_cast<Index>(i)};
  std::partial_sort(lots.begin(), lots.begin() + static_cast<std::ptrdiff_t>(count), lots.end());
  std::vector<Index> chosen(count);
  for (std::size_t i = 0; i < count; ++i) chosen[i] = lots[i].second;
  return chosen;
}

std::size_t share_of(std::size_t n, double share) {
  return static_cast<std::size_t>(std::llround(share * static_cast<double>(n)));
}

/// What is wrong with the measured distance of a ray, apart from outliers and spikes, in the unit of noise and bias.
double range_error(const Hit& hit, const View& view, double noise, double bias, const ScanOptions& options,
                   std::uint64_t seed) {
  const double cosine = std::max(0.1, -hit.direction.dot(hit.normal));
  return noise * std::pow(cosine, -options.noise_growth) * random_normal(seed, range_noise, ray_counter(hit)) +
         bias * view.bias(hit.image);
}

}  // namespace

void ScanOptions::check() const {
  check_fields(*this);
  if (outlier_share + spike_share > 1)
    throw OptionError("outliers and spikes must be at most 1 together, not " + to_text(outlier_share + spike_share));
}

ScanOptions scan_quality(ScanQuality quality) {
  ScanOptions options;
  options.distance = 3;
  options.max_incidence = 81;
  options.noise_growth = 0.5;
  const auto set_registration = [&options](double shift, double angle) {
    options.registration_shift = Length::of_diagonal(shift / std::numbers::sqrt3);
    options.registration_angle = angle / std::numbers::sqrt3;
  };
  switch (quality) {
    case ScanQuality::s1:
      options.points = 300'000;
      options.views = 24;
      options.noise = Length::of_diagonal(0.0002);
      break;
    case ScanQuality::s2:
      options.points = 150'000;
      options.views = 16;
      options.noise = Length::of_diagonal(0.001);
      set_registration(0.0004, 0.03);
      options.outlier_share = 0.001;
      break;
    case ScanQuality::s3:
      options.points = 75'000;
      options.views = 12;
      options.noise = Length::of_diagonal(0.0025);
      options.bias = Length::of_diagonal(0.001);
      set_registration(0.0012, 0.1);
      options.outlier_share = 0.01;
      options.spike_share = 0.005;
      options.max_incidence = 72;
      break;
  }
  return options;
}

VirtualScan virtual_scan(const ScanTarget& target, const ScanOptions& options, const RunContext& context) {
  options.check();
  const std::uint64_t seed = context.seed;
  const std::vector<View> views = place_views(target, options, seed);
  std::vector<Hit> hits = trace_views(target, views, options, context);
  std::stable_sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.view < b.view; });

  VirtualScan result;
  const std::size_t n = hits.size();
  const std::size_t outliers = share_of(n, options.outlier_share);
  const std::vector<Index> wrong = choose(std::min(n, outliers + share_of(n, options.spike_share)), n, seed);
  const auto first_spike = wrong.begin() + static_cast<std::ptrdiff_t>(outliers);
  result.outliers.assign(wrong.begin(), first_spike);
  result.spikes.assign(first_spike, wrong.end());
  std::sort(result.outliers.begin(), result.outliers.end());
  std::sort(result.spikes.begin(), result.spikes.end());
  enum Kind : char { measured, outlier, spike };
  std::vector<Kind> kind(n, measured);
  for (const Index i : result.outliers) kind[i] = outlier;
  for (const Index i : result.spikes) kind[i] = spike;

  result.cloud.positions.resize(n);
  result.cloud.normals.resize(n);
  result.cloud.sensors.resize(n);
  result.surface.resize(n);
  result.view.resize(n);
  const double diagonal = target.diagonal(), radius = target.bounding_radius();
  const double noise = share_of(options.noise, target), bias = share_of(options.bias, target);
  const double largest_spike = share_of(options.spike_length, target);
  parallel_for(n, context, [&](std::size_t i) {
    const Hit& hit = hits[i];
    const View& view = views[hit.view];
    const auto symmetric = [&](Stream stream) { return 2 * random_uniform(seed, stream, ray_counter(hit)) - 1; };
    double error = range_error(hit, view, noise, bias, options, seed);
    if (kind[i] == spike) error += largest_spike * symmetric(spike_length);
    const Vec3 position =
        kind[i] == outlier ? Vec3(view.sensor + (options.distance + symmetric(outlier_place)) * radius * hit.direction)
                           : Vec3(hit.point + error * diagonal * hit.direction);
    result.cloud.positions[i] = view.registered(position);
    result.cloud.normals[i] = view.rotation_error * hit.normal;
    result.cloud.sensors[i] = view.registered(view.sensor);
    result.surface[i] = hit.point;
    result.view[i] = hit.view;
  });
  return result;
}

}  // namespace gpsrecon::internal
