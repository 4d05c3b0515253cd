#pragma once

#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <array>
#include <string>
#include <string_view>

namespace gpsrecon {

enum class ParticleSelection {
  random,   ///< independent of each other
  uniform,  ///< evenly over the surface, however dense the points are there
};

constexpr std::array<std::string_view, 2> option_names(ParticleSelection /*type*/) {
  return {"random", "uniform"};
}

/// A number of particles, or a multiple of that of the points.
struct ParticleCount {
  std::size_t count = 0;  ///< 0: `ratio`
  double ratio = 1;       ///< (0, 100]

  static constexpr const char* placeholder = "all|N|X%";
  /// `all`, a number above 0, or a percentage in (0, 10000]. Throws OptionError.
  static ParticleCount parse(const std::string& text);
  std::string text() const;
};

/// Which particles represent a cloud.
struct ParticleOptions {
  ParticleCount particles = {};
  ParticleSelection selection = ParticleSelection::random;

  static OptionTable fields() {
    using O = ParticleOptions;
    return {
        field<&O::particles>("particles", "",
                             "particles: the points, N > 0 of them, or X in (0, 10000] percent; above 100 % there are "
                             "new ones among them"),
        field<&O::selection>("selection", "",
                             "which points, where there are fewer particles: any, independent of each other, or "
                             "evenly over the surface, however dense they are there")};
  }
  /// Throws OptionError naming option, range and value.
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
