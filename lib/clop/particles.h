#pragma once

#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>

namespace gpsrecon {

enum class ParticleSelection {
  random,   ///< independent of each other
  uniform,  ///< evenly over the surface, however dense the points are there
};

/// Which particles represent a cloud.
struct ParticleOptions {
  /// Number of particles. Range: >= 0; 0 = `ratio`.
  std::size_t count = 0;
  /// Number of particles as a multiple of that of the points. Range: (0, 100].
  double ratio = 1;
  /// Which points, where there are fewer particles than points.
  ParticleSelection selection = ParticleSelection::random;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// Particles to start a projection from, with the attributes of the points they come from and in their order.
/// As many as points: these. Fewer: a subset; a uniform one takes one point per cell of a grid whose cells are as large
/// as the count allows, and fills up at random. More: all points and, spread evenly over them, new particles between a
/// point and one of its eight nearest neighbours, so that none coincide where points do not.
/// At least one; the points are a non-empty cloud. O(n log n). Throws OptionError.
PointCloud choose_particles(const PointCloud& points, const ParticleOptions& options = {},
                            const RunContext& context = {});

/// Gives every particle the colour, scalars and sensor of the point nearest to it, in place of its own. Both in one
/// frame. O((n + m) log m).
void attributes_from_nearest(PointCloud& particles, const PointCloud& points, const RunContext& context = {});

}  // namespace gpsrecon
