#include "datasets/virtual_scan.h"

#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>

namespace gpsrecon::datasets {
namespace {

/// What random numbers are drawn for; each purpose has a stream of its own.
enum Stream : std::uint64_t { image_offset, range_noise, shift, rotation, outlier_choice, outlier_place };

/// One camera, with the error of its registration.
struct View {
  Vec3 sensor;
  Vec3 forward, right, up;
  Vec2 offset;  ///< start of its sequence of image points
  Mat3 rotation_error;
  Vec3 shift_error;

  Vec3 registered(const Vec3& p) const { return rotation_error * p + shift_error; }
};

struct Hit {
  Vec3 point, normal, direction;
  Index view;
  std::uint64_t ray;  ///< number of the ray within the view
};

template <class T>
void require(bool condition, const char* field, const T& value, const char* range) {
  if (condition) return;
  std::ostringstream message;
  message << field << " = " << value << " is out of range " << range;
  throw OptionError(message.str());
}

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

/// Cameras on a Fibonacci lattice of the sphere.
std::vector<View> place_views(const ScanOptions& options, double bounding_radius, std::uint64_t seed) {
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<View> views(static_cast<std::size_t>(options.views));
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double z = 1 - (2 * static_cast<double>(v) + 1) / options.views;
    const double rho = std::sqrt(1 - z * z), phi = golden_angle * static_cast<double>(v);
    const Vec3 outward(rho * std::cos(phi), rho * std::sin(phi), z);
    View& view = views[v];
    view.sensor = options.distance * bounding_radius * outward;
    view.forward = -outward;
    view.right = outward.unitOrthogonal();
    view.up = view.right.cross(view.forward);
    view.offset = {random_uniform(seed, image_offset, 2 * v), random_uniform(seed, image_offset, 2 * v + 1)};
    view.shift_error = options.registration_shift * random_normal_vector(seed, shift, v);
    const Vec3 turn = options.registration_angle * random_normal_vector(seed, rotation, v);
    view.rotation_error =
        turn.isZero(0) ? Mat3(Mat3::Identity()) : Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  return views;
}

/// Ray number `ray` of a view. The image points are the two-dimensional golden-ratio sequence (multiples, modulo 1, of
/// the inverse powers of the root of x³ = x + 1), every prefix of which covers the image evenly.
Vec3 ray_direction(const View& view, std::uint64_t ray, double half_width) {
  constexpr double plastic = 1.32471795724474602596;
  const auto image = [&](double offset, double step) {
    const double x = offset + static_cast<double>(ray) * step;
    return half_width * (2 * (x - std::floor(x)) - 1);
  };
  return (view.forward + image(view.offset.x(), 1 / plastic) * view.right +
          image(view.offset.y(), 1 / (plastic * plastic)) * view.up)
      .normalized();
}

/// First point where a ray from outside meets the solid, by sphere tracing: the distance to the surface is how far one
/// may safely go.
std::optional<SurfacePoint> trace(const Solid& solid, const Vec3& sensor, const Vec3& direction) {
  constexpr int max_steps = 400;  // only rays that graze the surface need more, and those are not measured
  const double radius = solid.bounding_radius();
  const double middle = -sensor.dot(direction);
  const double squared_half_chord = radius * radius - (sensor + middle * direction).squaredNorm();
  if (squared_half_chord <= 0) return std::nullopt;
  const double half_chord = std::sqrt(squared_half_chord);
  double t = std::max(0.0, middle - half_chord);
  for (int step = 0; step < max_steps && t <= middle + half_chord; ++step) {
    const SurfacePoint q = solid.closest(sensor + t * direction);
    if (q.distance <= 1e-10 * radius) return q;
    t += q.distance;
  }
  return std::nullopt;
}

/// The first `options.points` rays, taking one of each view in turn, that give a point.
std::vector<Hit> trace_views(const Solid& solid, const std::vector<View>& views, const ScanOptions& options,
                             const RunContext& context) {
  const double half_width = 1 / std::sqrt(options.distance * options.distance - 1);  // tangent of the cone's half angle
  const double min_cosine = std::cos(options.max_incidence);
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
          const Vec3 direction = ray_direction(views[v], ray, half_width);
          slots[slot].reset();
          const std::optional<SurfacePoint> q = trace(solid, views[v].sensor, direction);
          if (q && -direction.dot(q->normal) >= min_cosine)
            slots[slot] = Hit{q->point, q->normal, direction, static_cast<Index>(v), ray};
        },
        512);
    const std::size_t before = hits.size();
    for (const std::optional<Hit>& slot : slots)
      if (slot && hits.size() < options.points) hits.push_back(*slot);
    if (hits.size() == before) throw NoSurfaceError("no ray of the virtual scan meets the solid");
    context.progress("scan", static_cast<double>(hits.size()) / static_cast<double>(options.points));
  }
  return hits;
}

/// `count` of the numbers below n, all subsets equally likely, ascending.
std::vector<Index> choose(std::size_t count, std::size_t n, std::uint64_t seed) {
  std::vector<std::pair<std::uint64_t, Index>> lots(n);
  for (std::size_t i = 0; i < n; ++i) lots[i] = {random_bits(seed, outlier_choice, i), static_cast<Index>(i)};
  std::nth_element(lots.begin(), lots.begin() + static_cast<std::ptrdiff_t>(count), lots.end());
  std::vector<Index> chosen(count);
  for (std::size_t i = 0; i < count; ++i) chosen[i] = lots[i].second;
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

void ScanOptions::check() const {
  require(points >= 1 && points < no_index, "points", points, "[1, 2^32 - 2]");
  require(views >= 1 && views <= 10'000, "views", views, "[1, 10000]");
  require(distance > 1 && distance <= 1000, "distance", distance, "(1, 1000]");
  require(max_incidence > 0 && max_incidence <= std::numbers::pi / 2, "max_incidence", max_incidence, "(0, pi/2]");
  require(noise >= 0 && std::isfinite(noise), "noise", noise, "[0, inf)");
  require(registration_shift >= 0 && std::isfinite(registration_shift), "registration_shift", registration_shift,
          "[0, inf)");
  require(registration_angle >= 0 && std::isfinite(registration_angle), "registration_angle", registration_angle,
          "[0, inf)");
  require(outliers <= points, "outliers", outliers, "[0, points]");
}

VirtualScan scan(const Solid& solid, const ScanOptions& options, const RunContext& context) {
  options.check();
  const std::uint64_t seed = context.seed;
  const std::vector<View> views = place_views(options, solid.bounding_radius(), seed);
  std::vector<Hit> hits = trace_views(solid, views, options, context);
  std::stable_sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.view < b.view; });

  VirtualScan result;
  const std::size_t n = hits.size();
  result.outliers = choose(options.outliers, n, seed);
  std::vector<char> is_outlier(n, 0);
  for (const Index i : result.outliers) is_outlier[i] = 1;
  result.cloud.positions.resize(n);
  result.cloud.normals.resize(n);
  result.cloud.sensors.resize(n);
  result.surface.resize(n);
  result.view.resize(n);
  parallel_for(n, context, [&](std::size_t i) {
    const Hit& hit = hits[i];
    const View& view = views[hit.view];
    Vec3 measured = hit.point + options.noise * random_normal(seed, range_noise, ray_counter(hit)) * hit.direction;
    if (is_outlier[i] != 0) {
      const double place = 2 * random_uniform(seed, outlier_place, ray_counter(hit)) - 1;
      measured = view.sensor + (options.distance + place) * solid.bounding_radius() * hit.direction;
    }
    result.cloud.positions[i] = view.registered(measured);
    result.cloud.normals[i] = view.rotation_error * hit.normal;
    result.cloud.sensors[i] = view.registered(view.sensor);
    result.surface[i] = hit.point;
    result.view[i] = hit.view;
  });
  return result;
}

}  // namespace gpsrecon::datasets
