#pragma once

#include <gpsrecon/clop/normals.h>
#include <gpsrecon/clop/orientation.h>
#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/prepared_cloud.h>
#include <gpsrecon/hem/hem.h>
#include <array>
#include <optional>
#include <string_view>

namespace gpsrecon {

/// What decides the side of normals.
enum class NormalOrientation {
  automatic,  ///< the first of surface, sensor and neighbours that is at hand
  none,       ///< nothing: their signs are arbitrary
  surface,    ///< the nearest face of a mesh
  sensor,     ///< where the sensor stood
  neighbors,  ///< each other: propagation along a minimum spanning tree, then outward
};

constexpr std::array<std::string_view, 5> option_names(NormalOrientation /*type*/) {
  return {"auto", "none", "surface", "sensor", "mst"};
}

struct PointNormalsOptions {
  NormalMethod method = NormalMethod::weiszfeld;
  /// Its `h` follows from support_radius and is refused.
  NormalOptions normals;
  Length support_radius = {};
  NormalOrientation orientation = NormalOrientation::automatic;
  PropagationOptions propagation;
  std::optional<Vec3> sensor;
  ScaleOptions scale;
  /// Of the mixture that `NormalMethod::csw` reduces the points to, less than for a surface: medians of few Gaussians
  /// jump from the normal of one to that of the next.
  HemOptions mixture{.alpha = 1.5, .flat_levels = 0};

  static OptionTable fields() {
    using O = PointNormalsOptions;
    return {
        field<&O::method>("method", "",
                          "planes through the nearest points, the spherical medians of their normals around each "
                          "point, or those of a mixture of the points"),
        field<&O::support_radius>("support-radius", "> 0", "radius within which medians are taken"),
        field<&O::orientation>("orient", "",
                               "side of the normals: arbitrary (none), of the nearest face of --surface, of the sensor "
                               "(--sensor or columns sx sy sz), or from neighbour to neighbour along a minimum "
                               "spanning tree, then outward (mst); auto takes the first of the last three at hand"),
        field<&O::sensor>("sensor", "",
                          "where the sensor stood, in the coordinates of the input; takes precedence over columns sx "
                          "sy sz")
            .or_else("unknown")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const;
};

/// What else normals can be taken from. Both are in frames of their own.
struct NormalSources {
  const Mesh* surface = nullptr;     ///< decides the side of the normals
  const Mixture* mixture = nullptr;  ///< for `NormalMethod::csw`, instead of one of the points; has normals
};

/// The finite points of a cloud in world coordinates, in their order and with all attributes, and their normals, in
/// place of those they have. Equal points have equal normals. Isolated points (core/scale.h) have normals but do not
/// count for those of others. O(n log n + n k). Throws OptionError, also for an orientation without what it needs;
/// InputError if no point is finite, the surface has no faces or the mixture no normals; NoSurfaceError if there are
/// only one or two points, equal or on a line; Cancelled.
PointCloud point_normals(const PointCloud& world, const PointNormalsOptions& options = {},
                         const NormalSources& sources = {}, const RunContext& context = {});

}  // namespace gpsrecon
