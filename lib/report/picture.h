#pragma once

#include <gpsrecon/core/mesh.h>
#include <string>

namespace gpsrecon::internal {

/// A picture, row by row from the top.
struct Picture {
  std::size_t width = 0, height = 0;
  std::vector<Color> pixels;
};

/// A direction from which much of a mesh is seen: along the axis of least spread of its vertices, a little from the
/// side and above; up is z, or y where that would be looked along.
struct View {
  Vec3 from = Vec3::UnitX(), up = Vec3::UnitZ();  ///< unit vectors
};
View good_view(const Mesh& mesh);

/// Draws a mesh with its colours (white without any) on white, from far away, lit from the front, both sides of faces
/// alike. O(faces + covered pixels).
Picture draw(const Mesh& mesh, const View& view, std::size_t width, std::size_t height);

/// The bytes of a Windows bitmap of 24 bits, which every browser shows.
std::string to_bitmap(const Picture& picture);

}  // namespace gpsrecon::internal
