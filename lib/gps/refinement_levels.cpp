#include <gpsrecon/gps/refinement_levels.h>

#include <gpsrecon/core/error.h>
#include <cmath>
#include <limits>
#include <string>

namespace gpsrecon::internal {

void check_levels(const Connectivity& control, int levels, const SurfaceRules& rules) {
  if (levels < 0) throw OptionError("levels: " + std::to_string(levels) + " is negative");
  const bool quads = rules.scheme == Scheme::catmull_clark;
  if (levels == 0 && quads && control.corners_per_face != 4)
    throw OptionError("levels must be at least 1 for Catmull-Clark surfaces with faces of other than four corners");
  // The longest index runs over the entries of the limits of all samples: fewer than twelve per triangle, four per
  // corner of a polygon.
  const double entries =
      quads ? 4.0 * static_cast<double>(control.half_edge_count()) : 12.0 * static_cast<double>(control.face_total());
  if (std::ldexp(entries, 2 * levels) >= std::numeric_limits<Index>::max())
    throw OptionError("levels: " + std::to_string(levels) + " refinements of " + std::to_string(control.face_total()) +
                      " faces are more than can be indexed");
}

}  // namespace gpsrecon::internal
