// Projection: Preiner et al. 2014, Eq. 2-6 and sections 6-8; Lipman et al. 2007 (LOP), Huang et al. 2009 (WLOP).

#include <gpsrecon/clop/project.h>

#include <gpsrecon/clop/attraction.h>
#include <gpsrecon/clop/repulsion.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr std::size_t particles_per_block = 512;
constexpr double jitter = 0.01;  // of coinciding particles, in support radii
constexpr std::uint64_t jitter_stream = 0x6A17;

Vec3 random_direction(std::uint64_t seed, std::uint64_t counter) {
  const double z = 2 * random_uniform(seed, jitter_stream, 2 * counter) - 1;
  const double angle = 2 * std::numbers::pi * random_uniform(seed, jitter_stream, 2 * counter + 1);
  const double ring = std::sqrt(1 - z * z);
  return {ring * std::cos(angle), ring * std::sin(angle), z};
}

/// Particles at one point would never part: their repulsion is a multiple of their difference. All but the first of
/// them are moved.
void part_coinciding(std::vector<Vec3>& positions, double h, std::uint64_t seed) {
  std::vector<Index> order(positions.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    const Vec3 &p = positions[a], &q = positions[b];
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    if (p.z() != q.z()) return p.z() < q.z();
    return a < b;
  });
  std::vector<Index> moved;
  for (std::size_t k = 1; k < order.size(); ++k)
    if (positions[order[k]] == positions[order[k - 1]]) moved.push_back(order[k]);
  for (const Index i : moved) positions[i] += jitter * h * random_direction(seed, i);
}

/// Whether this iteration computes the repulsion anew: every interval-th from the second on, and the last.
bool renews_repulsion(int iteration, const ProjectOptions& options) {
  return (iteration - 2) % options.repulsion_interval == 0 || iteration == options.iterations;
}

/// Eq. 3 for all particles at once: what they all see are the positions of the iteration before.
PointCloud iterate(const PointCloud& particles, const Attraction& attraction, const ProjectOptions& options,
                   const RunContext& context) {
  PointCloud result = particles;
  std::vector<Vec3>& positions = result.positions;
  const std::size_t n = positions.size();
  const double h = options.support_radius;
  part_coinciding(positions, h, context.seed);
  std::vector<Vec3> repulsion(n, Vec3::Zero());
  std::vector<double> moves((n + particles_per_block - 1) / particles_per_block);
  for (int iteration = 1; iteration <= options.iterations; ++iteration) {
    const ProjectionStep step = iteration == 1 ? ProjectionStep::mean : ProjectionStep::median;
    if (iteration > 1 && options.repulsion > 0 && renews_repulsion(iteration, options))
      update_repulsion(positions, h, options.repulsion_cutoff, repulsion, context);
    parallel_blocks(
        n, context,
        [&](std::size_t block, std::size_t begin, std::size_t end) {
          std::vector<Neighbor> near;
          std::vector<std::optional<Vec3>> pulls(end - begin);
          attraction.pull({&positions[begin], end - begin}, step, near, pulls);
          double largest = 0;
          for (std::size_t i = begin; i < end; ++i) {
            if (!pulls[i - begin]) continue;
            const Vec3 move = *pulls[i - begin] + options.repulsion * repulsion[i];
            positions[i] += move;
            largest = std::max(largest, move.norm());
          }
          moves[block] = largest;
        },
        particles_per_block);
    const double largest = moves.empty() ? 0 : *std::max_element(moves.begin(), moves.end());
    if (options.on_iteration) options.on_iteration({iteration, positions, repulsion, largest});
    context.progress("project", static_cast<double>(iteration) / options.iterations);
    if (iteration > 1 && largest <= options.convergence * h) break;
  }
  return result;
}

void check_input(const PointCloud& particles, const Frame& frame) {
  validate(particles);
  if (!(particles.frame == frame)) throw InvariantError("the particles are in another frame than what attracts them");
}

void check(const ProjectOptions& options) {
  options.check();
  if (!(options.support_radius > 0) || !std::isfinite(options.support_radius))
    throw OptionError("support_radius must be > 0, not " + to_text(options.support_radius));
}

}  // namespace

double automatic_support_radius(double spacing, double noise) {
  return 9 * std::hypot(spacing, 3 * noise);
}

PointCloud project(const PointCloud& particles, const Mixture& mixture, const ProjectOptions& options,
                   const RunContext& context) {
  check(options);
  check_input(particles, mixture.frame);
  validate(mixture);
  return iterate(particles, MixtureAttraction(mixture, options.support_radius, kernel_fit(options.kernel), context),
                 options, context);
}

PointCloud project(const PointCloud& particles, const PointCloud& points, const ProjectOptions& options,
                   const RunContext& context) {
  check(options);
  check_input(particles, points.frame);
  validate(points);
  return iterate(particles, PointAttraction(points, options.support_radius, options.balance, context), options,
                 context);
}

}  // namespace gpsrecon
