#pragma once

#include <array>
#include <string_view>

namespace gpsrecon {

/// How a control mesh is refined.
enum class Scheme {
  loop,           ///< Loop 1987; triangles
  catmull_clark,  ///< Catmull and Clark 1978; polygons
};
constexpr std::array<std::string_view, 2> option_names(Scheme /*type*/) {
  return {"loop", "catmull-clark"};
}

/// Weights of Loop's scheme at interior vertices of valence n.
enum class LoopWeights {
  loop,    ///< β = (5/8 - (3/8 + cos(2π/n)/4)²)/n, Loop 1987
  warren,  ///< β = 3/16 for n = 3, 3/(8n) otherwise; refinement and masks only
};
constexpr std::array<std::string_view, 2> option_names(LoopWeights /*type*/) {
  return {"loop", "warren"};
}

/// What to do with boundary vertices of a single face.
enum class CornerRule {
  smooth,  ///< like any boundary vertex
  sharp,   ///< kept
};
constexpr std::array<std::string_view, 2> option_names(CornerRule /*type*/) {
  return {"smooth", "sharp"};
}

/// Which smooth surface a control mesh stands for. Part of a covariance mesh, like its vertices and faces: what fits,
/// refines, evaluates or compares the surface reads them there.
struct SurfaceRules {
  Scheme scheme = Scheme::loop;
  LoopWeights weights = LoopWeights::loop;  ///< of Scheme::loop
  CornerRule corners = CornerRule::smooth;

  friend bool operator==(const SurfaceRules&, const SurfaceRules&) = default;
};

}  // namespace gpsrecon
