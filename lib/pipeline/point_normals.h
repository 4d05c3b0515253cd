#pragma once

#include <gpsrecon/clop/normals.h>
#include <gpsrecon/clop/orientation.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <optional>

namespace gpsrecon {

/// What decides the side of normals.
enum class NormalOrientation {
  automatic,  ///< the first of surface, sensor and neighbours that is at hand
  none,       ///< nothing: their signs are arbitrary
  surface,    ///< the nearest face of a mesh
  sensor,     ///< where the sensor stood
  neighbors,  ///< each other: propagation along a minimum spanning tree, then outward
};

struct PointNormalsOptions {
  NormalMethod method = NormalMethod::weiszfeld;
  /// `h` is not used: see h_rel.
  NormalOptions normals;
  /// Support radius h of the median as a share of the diagonal. Range: (0, 1]; 0 = automatic.
  double h_rel = 0;
  NormalOrientation orientation = NormalOrientation::automatic;
  PropagationOptions propagation;
  /// Where the sensor stood, in world coordinates; takes precedence over the sensors of the points.
  std::optional<Vec3> sensor;
  ScaleOptions scale;
  /// Of the mixture that `NormalMethod::csw` reduces the points to, less than for a surface: medians of few Gaussians
  /// jump from the normal of one to that of the next.
  ReconstructOptions mixture = [] {
    ReconstructOptions options;
    options.hem.alpha = 1.5;
    options.hem.flat_levels = 0;
    return options;
  }();

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// What else normals can be taken from. Both are in frames of their own.
struct NormalSources {
  const Mesh* surface = nullptr;     ///< decides the side of the normals
  const Mixture* mixture = nullptr;  ///< for `NormalMethod::csw`, instead of one of the points; has normals
};

/// The finite points of a cloud in world coordinates, in their order and with all attributes, and their normals, in
/// place of those they have. Equal points have equal normals. Isolated points (hem/scale.h) have normals but do not
/// count for those of others. O(n log n + n k). Throws OptionError, also for an orientation without what it needs;
/// InputError if no point is finite, the surface has no faces or the mixture no normals; NoSurfaceError if there are
/// only one or two points, equal or on a line; Cancelled.
PointCloud point_normals(const PointCloud& world, const PointNormalsOptions& options = {},
                         const NormalSources& sources = {}, const RunContext& context = {});

}  // namespace gpsrecon
