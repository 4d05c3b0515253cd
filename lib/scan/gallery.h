#pragma once

#include <gpsrecon/scan/shapes.h>
#include <memory>
#include <string>
#include <vector>

namespace gpsrecon::internal {

/// A shape that has a name.
struct GalleryShape {
  std::string name;
  std::string what;  ///< one phrase
  int euler;         ///< Euler number of the surface
  int boundaries;    ///< number of its boundary loops
};

/// All shapes that make_shape() knows, each in one piece.
const std::vector<GalleryShape>& gallery();

/// Throws OptionError, listing the names, if there is no such shape.
std::unique_ptr<const Shape> make_shape(const std::string& name);

/// A ball of radius 20 with a bore, a flat-topped boss, a knob on a filleted neck, a conical pit and a flat, turned out
/// of the coordinate axes: genus 1.
TurnedBall make_workpiece();

}  // namespace gpsrecon::internal
