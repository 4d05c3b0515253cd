// Preiner et al. 2014, Eq. 5-6.

#include <gpsrecon/clop/repulsion.h>

#include <gpsrecon/clop/kernel.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <vector>

namespace gpsrecon::internal {

void update_repulsion(std::span<const Vec3> particles, double support_radius, double cutoff, std::span<Vec3> repulsion,
                      const RunContext& context) {
  const Neighbors index(particles);
  parallel_blocks(
      particles.size(), context,
      [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t i = begin; i < end; ++i) {
          index.within(particles[i], cutoff * support_radius, near);
          double total = 0;
          Vec3 away = Vec3::Zero();
          for (const Neighbor& n : near) {
            if (!(n.distance > 0)) continue;  // itself
            const double beta = theta(n.distance / support_radius) / n.distance;
            total += beta;
            away += beta * (particles[i] - particles[n.index]);
          }
          repulsion[i] = total > 0 ? Vec3(away / total) : Vec3::Zero();
        }
      },
      512);
}

}  // namespace gpsrecon::internal
