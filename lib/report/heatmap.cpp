#include <gpsrecon/report/heatmap.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Knots of viridis (van der Walt and Smith 2015) and of ColorBrewer's RdBu, turned around.
constexpr std::array<Color, 10> viridis{{{68, 1, 84},
                                         {72, 40, 120},
                                         {62, 73, 137},
                                         {49, 104, 142},
                                         {38, 130, 142},
                                         {31, 158, 137},
                                         {53, 183, 121},
                                         {110, 206, 88},
                                         {181, 222, 43},
                                         {253, 231, 37}}};
constexpr std::array<Color, 7> blue_white_red{{{33, 102, 172},
                                               {103, 169, 207},
                                               {209, 229, 240},
                                               {247, 247, 247},
                                               {253, 219, 199},
                                               {239, 138, 98},
                                               {178, 24, 43}}};

Color between(std::span<const Color> knots, double share) {
  const double position = share * static_cast<double>(knots.size() - 1);
  const std::size_t k = std::min(static_cast<std::size_t>(position), knots.size() - 2);
  Color color;
  for (std::size_t c = 0; c < 3; ++c)
    color[c] = static_cast<std::uint8_t>(
        std::lround(knots[k][c] + (position - static_cast<double>(k)) * (knots[k + 1][c] - knots[k][c])));
  return color;
}

double percentile_99(const std::vector<double>& errors) {
  std::vector<double> magnitudes;
  for (const double e : errors)
    if (!std::isnan(e)) magnitudes.push_back(std::abs(e));
  if (magnitudes.empty()) return 0;
  return value_of_rank(magnitudes, static_cast<std::size_t>(0.99 * static_cast<double>(magnitudes.size() - 1)));
}

ErrorMap finished(std::vector<double> errors, double range, bool is_signed) {
  const double automatic = range > 0 ? range : percentile_99(errors);
  return {std::move(errors), automatic, is_signed};
}

void require_same_frame(const Frame& a, const Frame& b) {
  if (!(a == b)) throw InvariantError("error map: the frames differ");
}

}  // namespace

ErrorMap error_map(const Mesh& mesh, const Mesh& reference, double range, const RunContext& context) {
  require_same_frame(mesh.frame, reference.frame);
  const std::vector<ClosestPoint> found = SurfaceDistance(reference, context).distances(mesh.positions, context);
  std::vector<double> errors(found.size());
  for (std::size_t v = 0; v < errors.size(); ++v) {
    const bool below =
        area_vector(reference.positions, reference.faces[found[v].face]).dot(mesh.positions[v] - found[v].point) < 0;
    errors[v] = mesh.frame.scale() * (below ? -found[v].distance : found[v].distance);
  }
  return finished(std::move(errors), range, true);
}

ErrorMap error_map(const Mesh& mesh, const PointCloud& cloud, double range, const RunContext& context) {
  require_same_frame(mesh.frame, cloud.frame);
  const std::vector<ClosestPoint> found = SurfaceDistance(mesh, context).distances(cloud.positions, context);
  std::vector<double> sum(mesh.positions.size(), 0), weight(mesh.positions.size(), 0);
  for (std::size_t i = 0; i < found.size(); ++i)
    for (const Index v : mesh.faces[found[i].face]) {
      sum[v] += cloud.weight(i) * found[i].distance;
      weight[v] += cloud.weight(i);
    }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] = weight[v] > 0 ? mesh.frame.scale() * sum[v] / weight[v] : nan;
  return finished(std::move(sum), range, false);
}

std::vector<Color> palette(bool is_signed, std::size_t steps) {
  std::vector<Color> colors;
  for (std::size_t i = 0; i < steps; ++i) {
    const double share = steps > 1 ? static_cast<double>(i) / static_cast<double>(steps - 1) : 0;
    colors.push_back(is_signed ? between(blue_white_red, share) : between(viridis, share));
  }
  return colors;
}

std::size_t palette_index(const ErrorMap& map, double error, std::size_t steps) {
  if (std::isnan(error)) return steps;
  double share = map.range > 0 ? std::clamp(error / map.range, map.is_signed ? -1.0 : 0.0, 1.0) : 0;
  if (map.is_signed) share = (share + 1) / 2;
  return static_cast<std::size_t>(std::lround(share * static_cast<double>(steps - 1)));
}

Mesh colored(const Mesh& mesh, const ErrorMap& map) {
  constexpr std::size_t steps = 255;
  std::vector<Color> colors = palette(map.is_signed, steps);
  colors.push_back(no_error_color);
  Mesh result = mesh;
  result.colors.clear();
  for (const double e : map.errors) result.colors.push_back(colors[palette_index(map, e, steps)]);
  result.scalars = {{map.is_signed ? "signed_error" : "error", map.errors}};
  return result;
}

}  // namespace gpsrecon
