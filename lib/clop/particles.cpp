#include <gpsrecon/clop/particles.h>
#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr std::uint64_t choice_stream = 0xC401, between_stream = 0xBE77;
constexpr std::size_t between_neighbors = 8;

/// `count` of the candidates at random, ascending: those with the smallest random numbers.
std::vector<Index> random_subset(std::vector<Index> candidates, std::size_t count, std::uint64_t seed) {
  const auto key = [seed](Index i) { return random_bits(seed, choice_stream, i); };
  const auto nth = candidates.begin() + static_cast<std::ptrdiff_t>(count);
  if (nth != candidates.end()) {
    std::nth_element(candidates.begin(), nth, candidates.end(), [&](Index a, Index b) {
      const std::uint64_t ka = key(a), kb = key(b);
      return ka != kb ? ka < kb : a < b;
    });
    candidates.erase(nth, candidates.end());
  }
  std::sort(candidates.begin(), candidates.end());
  return candidates;
}

using Cell = std::array<std::int64_t, 3>;

/// One point per occupied cell, the nearest to its middle, ascending.
std::vector<Index> one_per_cell(const std::vector<Vec3>& points, const Vec3& low, double cell) {
  struct Entry {
    Cell cell;
    double off;
    Index point;
    bool operator<(const Entry& b) const {
      if (cell != b.cell) return cell < b.cell;
      return off != b.off ? off < b.off : point < b.point;
    }
  };
  std::vector<Entry> entries(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 at = (points[i] - low) / cell;
    Vec3 middle;
    for (int axis = 0; axis < 3; ++axis) {
      middle[axis] = std::floor(at[axis]) + 0.5;
      entries[i].cell[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(std::floor(at[axis]));
    }
    entries[i].off = (at - middle).squaredNorm();
    entries[i].point = static_cast<Index>(i);
  }
  std::sort(entries.begin(), entries.end());
  std::vector<Index> chosen;
  for (std::size_t k = 0; k < entries.size(); ++k)
    if (k == 0 || entries[k].cell != entries[k - 1].cell) chosen.push_back(entries[k].point);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

/// The finest grid with at most `count` occupied cells, by bisection of the logarithm of its cells.
std::vector<Index> uniform_subset(const std::vector<Vec3>& points, std::size_t count, std::uint64_t seed) {
  const Box3 box = bounding_box(points);
  const double diagonal = diagonal_length(box);
  std::vector<Index> chosen{0};
  if (diagonal > 0) {
    // No finer than a millionth of the diagonal: cells must be countable.
    double coarse = 1, fine = 1e-6;
    for (int step = 0; step < 24; ++step) {
      const double middle = std::sqrt(coarse * fine);
      std::vector<Index> trial = one_per_cell(points, box.min(), middle * diagonal);
      if (trial.size() <= count) {
        coarse = middle;
        if (trial.size() > chosen.size()) chosen = std::move(trial);
      } else {
        fine = middle;
      }
    }
  }
  if (chosen.size() > count) chosen = random_subset(std::move(chosen), count, seed);
  if (chosen.size() < count) {
    std::vector<Index> all(points.size()), rest;
    std::iota(all.begin(), all.end(), Index{0});
    std::set_difference(all.begin(), all.end(), chosen.begin(), chosen.end(), std::back_inserter(rest));
    rest = random_subset(std::move(rest), count - chosen.size(), seed);
    chosen.insert(chosen.end(), rest.begin(), rest.end());
    std::sort(chosen.begin(), chosen.end());
  }
  return chosen;
}

/// All points and `count - n` new ones among them, each behind the point it comes from.
PointCloud upsampled(const PointCloud& points, std::size_t count, const RunContext& context) {
  const std::size_t n = points.size();
  std::vector<Index> source(count);
  for (std::size_t k = 0; k < count; ++k) source[k] = static_cast<Index>(k * n / count);
  PointCloud particles = select(points, source);
  const Neighbors index(points.positions);
  parallel_blocks(
      count, context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
          if (k == 0 || source[k] != source[k - 1]) continue;  // the point itself
          const Vec3& p = points.positions[source[k]];
          index.nearest(p, between_neighbors + 1, near);
          const std::size_t others = near.size() - 1;
          if (others == 0) continue;
          const auto pick = static_cast<std::size_t>(random_uniform(context.seed, between_stream, 2 * k) *
                                                     static_cast<double>(others));
          const double share = random_uniform(context.seed, between_stream, 2 * k + 1);
          particles.positions[k] += share * (points.positions[near[1 + pick].index] - p);
        }
      },
      1024);
  return particles;
}

}  // namespace

ParticleCount ParticleCount::parse(const std::string& text) {
  constexpr const char* expected = "all, a positive number N or X%";
  ParticleCount particles;
  if (text == "all") return particles;
  if (text.ends_with('%')) {
    particles.ratio = parse_double(text.substr(0, text.size() - 1)) / 100;
  } else {
    particles.count = parse_natural(text);
    if (particles.count == 0) throw_expected(expected, text);
  }
  return particles;
}

std::string ParticleCount::text() const {
  if (count > 0) return std::to_string(count);
  return ratio == 1 ? "all" : to_text(100 * ratio) + "%";
}

void ParticleOptions::check() const {
  check_fields(*this);
  if (!(particles.ratio > 0 && particles.ratio <= 100))
    throw OptionError("particles must be in (0, 10000] percent, not " + to_text(100 * particles.ratio));
  if (particles.count >= no_index)
    throw OptionError("particles must be fewer than 2^32 - 1, not " + std::to_string(particles.count));
}

PointCloud choose_particles(const PointCloud& points, const ParticleOptions& options, const RunContext& context) {
  options.check();
  const std::size_t n = points.size();
  const std::size_t count =
      options.particles.count > 0
          ? options.particles.count
          : std::max<std::size_t>(
                1, static_cast<std::size_t>(std::llround(options.particles.ratio * static_cast<double>(n))));
  if (n == 0 || count == n) return points;
  PointCloud particles;
  if (count > n) {
    particles = upsampled(points, count, context);
  } else if (options.selection == ParticleSelection::uniform) {
    particles = select(points, uniform_subset(points.positions, count, context.seed));
  } else {
    std::vector<Index> all(n);
    std::iota(all.begin(), all.end(), Index{0});
    particles = select(points, random_subset(std::move(all), count, context.seed));
  }
  particles.weights.clear();  // of coinciding points; particles are what they are
  return particles;
}

void attributes_from_nearest(PointCloud& particles, const PointCloud& points, const RunContext& context) {
  const Neighbors index(points.positions);
  std::vector<Index> nearest(particles.size());
  parallel_blocks(
      particles.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t i = begin; i < end; ++i) {
          index.nearest(particles.positions[i], 1, near);
          nearest[i] = near.front().index;
        }
      },
      1024);
  PointCloud from = select(points, nearest);
  particles.colors = std::move(from.colors);
  particles.scalars = std::move(from.scalars);
  particles.sensors = std::move(from.sensors);
}

}  // namespace gpsrecon
