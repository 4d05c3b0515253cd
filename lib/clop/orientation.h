#pragma once

#include <gpsrecon/core/options.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/core/vec.h>
#include <span>
#include <vector>

namespace gpsrecon {

/// Turns every normal to the side of its direction: to the sensor, of a nearest face. Directions need not be of unit
/// length; normals across their direction stay. O(n). Throws InvariantError if the lengths differ.
void orient_along(std::vector<Vec3>& normals, std::span<const Vec3> directions);

struct PropagationOptions {
  int neighbors = 12;

  static OptionTable fields() {
    return {field<&PropagationOptions::neighbors>(
        "orient-neighbors", "[1, 1000]",
        "nearest points, itself not counted, that a point is linked with where normals are oriented along a tree")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// Orients normals from neighbour to neighbour along a minimum spanning forest of the graph of nearest neighbours
/// (Hoppe et al. 1992; ties by index). Two normals agree if one of them, mirrored at the plane between the points, has
/// the side of the other, which is exact for circular arcs and right across edges; links cost more the less the axes
/// agree so, and the more they run along the normals, from sheet to sheet. Each component of the graph is turned
/// outward, as the normals at its extremes in 26 directions show, outliers aside; where these contradict each other, as
/// on open surfaces, up along z, as the highest do. So a cavity in a solid is oriented outward too, into the solid.
/// Returns the number of components. O(n k log(n k)) time, O(n k) memory. Throws
/// OptionError; InvariantError if the lengths differ; Cancelled.
std::size_t orient_by_propagation(std::vector<Vec3>& normals, std::span<const Vec3> positions,
                                  const PropagationOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
