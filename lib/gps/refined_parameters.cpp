#include <gpsrecon/gps/refined_parameters.h>
#include <array>

namespace gpsrecon::internal {
namespace {

/// The corners of a face, in parameters of its patch.
template <std::size_t N>
using Corners = std::array<Eigen::Vector2d, N>;

constexpr std::size_t children = 4;

Corners<3> child(const Corners<3>& c, std::size_t i) {
  const Eigen::Vector2d ab = 0.5 * (c[0] + c[1]), bc = 0.5 * (c[1] + c[2]), ca = 0.5 * (c[2] + c[0]);
  switch (i) {
    case 0:
      return {c[0], ab, ca};
    case 1:
      return {c[1], bc, ab};
    case 2:
      return {c[2], ca, bc};
    default:
      return {ab, bc, ca};
  }
}

Corners<4> child(const Corners<4>& c, std::size_t i) {
  return {c[i], 0.5 * (c[i] + c[(i + 1) % 4]), 0.5 * (c[0] + c[2]), 0.5 * (c[(i + 3) % 4] + c[i])};
}

template <std::size_t N>
void set_descendants(Index patch, const Corners<N>& corners, int levels, const FaceList& refined, std::size_t& face,
                     std::vector<SurfaceParameter>& parameters) {
  if (levels > 0) {
    for (std::size_t i = 0; i < children; ++i)
      set_descendants(patch, child(corners, i), levels - 1, refined, face, parameters);
    return;
  }
  const std::span<const Index> vertices = refined[face++];
  for (std::size_t i = 0; i < N; ++i)
    if (SurfaceParameter& parameter = parameters[vertices[i]]; parameter.patch == no_index)
      parameter = {patch, corners[i].x(), corners[i].y()};
}

const Corners<3> triangle{{{0, 0}, {1, 0}, {0, 1}}};
const Corners<4> square{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

}  // namespace

std::vector<SurfaceParameter> refined_parameters(const FaceList& control, const FaceList& refined,
                                                 std::size_t vertex_count, int levels, Scheme scheme) {
  std::vector<SurfaceParameter> parameters(vertex_count, {no_index, 0, 0});
  std::size_t face = 0;
  Index patch = 0;
  for (std::size_t f = 0; f < control.size(); ++f) {
    const std::span<const Index> corners = control[f];
    if (scheme == Scheme::loop) {
      set_descendants(patch++, triangle, levels, refined, face, parameters);
    } else if (corners.size() == 4) {
      set_descendants(patch++, square, levels, refined, face, parameters);
    } else if (levels > 0) {
      for (std::size_t i = 0; i < corners.size(); ++i)
        set_descendants(patch++, square, levels - 1, refined, face, parameters);
    } else {
      for (const Index v : refined[face++]) {
        if (parameters[v].patch == no_index) parameters[v].patch = patch;
        ++patch;
      }
    }
  }
  return parameters;
}

}  // namespace gpsrecon::internal
