#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <span>
#include <vector>

namespace gpsrecon {

/// Errors at the vertices of a mesh, to be shown in colours.
struct ErrorMap {
  std::vector<double> errors;  ///< per vertex, scene units; NaN where nothing is known
  double range = 0;            ///< errors up to this magnitude have colours of their own; 0 if all are 0
  bool is_signed = false;      ///< positive on the outer side of the reference
};

/// Signed distance of every vertex of `mesh` to `reference`, positive on the side of its normals. The range is the 99th
/// percentile of the magnitudes, or `range` if that is above 0 (scene units). The frames must be the same. O(n log m).
/// Throws InvariantError as SurfaceDistance.
ErrorMap error_map(const Mesh& mesh, const Mesh& reference, double range = 0, const RunContext& context = {});

/// Mean distance of the points whose footpoint lies on a face at the vertex; NaN where there are none. Otherwise as
/// above, unsigned.
ErrorMap error_map(const Mesh& mesh, const PointCloud& cloud, double range = 0, const RunContext& context = {});

/// The colours of an error map in `steps` steps: for unsigned errors from 0 to the range those of viridis, from dark
/// blue to yellow; for signed ones from blue (-range) over white to red. Both are even to the eye and to those who do
/// not tell red from green.
std::vector<Color> palette(bool is_signed, std::size_t steps);

/// Number of the colour of an error in a palette of `steps`; `steps` itself for NaN, which is shown as
/// `no_error_color`.
std::size_t palette_index(const ErrorMap& map, double error, std::size_t steps);
inline constexpr Color no_error_color{170, 170, 170};

/// The mesh with the colours of its errors and the errors themselves as a column, "error" or "signed_error". Other
/// colours and columns are gone.
Mesh colored(const Mesh& mesh, const ErrorMap& map);

}  // namespace gpsrecon
