// Rasterisation by edge functions with a depth buffer: Pineda 1988.

#include <gpsrecon/report/picture.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/principal_axes.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gpsrecon::internal {

View good_view(const Mesh& mesh) {
  // The shape is flattest along the smallest axis: seen along it, most of it shows.
  View view;
  Vec3 from = eigen_decomposition(scatter(mesh.positions)).vectors.col(0);
  if (from[0] + from[1] + from[2] < 0) from = -from;
  view.up = Vec3::Unit(2);
  if (std::abs(from.z()) > 0.8) view.up = Vec3::Unit(1);
  const Vec3 side = view.up.cross(from).normalized();
  view.from = (from + 0.35 * side + 0.25 * view.up).normalized();
  return view;
}

Picture draw(const Mesh& mesh, const View& view, std::size_t width, std::size_t height) {
  const Vec3 right = view.up.cross(view.from).normalized(), up = view.from.cross(right);
  Picture picture{width, height, std::vector<Color>(width * height, Color{255, 255, 255})};
  std::vector<Vec3> seen(mesh.positions.size());  // right, up, towards the eye
  for (std::size_t v = 0; v < seen.size(); ++v) {
    const Vec3& p = mesh.positions[v];
    seen[v] = {right.dot(p), up.dot(p), view.from.dot(p)};
  }
  const Box3 box = bounding_box(seen);
  const auto w = static_cast<double>(width), h = static_cast<double>(height);
  const double scale =
      0.94 * std::min(w / std::max(box.diagonal().x(), 1e-300), h / std::max(box.diagonal().y(), 1e-300));
  const Vec3 middle = box.center();
  for (Vec3& p : seen) p = {w / 2 + scale * (p.x() - middle.x()), h / 2 - scale * (p.y() - middle.y()), scale * p.z()};

  std::vector<double> depth(width * height, -std::numeric_limits<double>::infinity());
  const auto draw_triangle = [&](Index ia, Index ib, Index ic) {
    const Vec3 &a = seen[ia], &b = seen[ib], &c = seen[ic];
    const Vec3 normal = area_vector(a, b, c);
    if (normal.z() == 0) return;
    const double light = 0.35 + 0.65 * std::abs(normal.z()) / normal.norm();
    const auto first = [](double x, double limit) { return std::clamp(std::ceil(x - 0.5), 0.0, limit); };
    const double x0 = first(std::min({a.x(), b.x(), c.x()}), w), x1 = first(std::max({a.x(), b.x(), c.x()}), w);
    const double y0 = first(std::min({a.y(), b.y(), c.y()}), h), y1 = first(std::max({a.y(), b.y(), c.y()}), h);
    for (auto y = static_cast<std::size_t>(y0); y < static_cast<std::size_t>(y1); ++y)
      for (auto x = static_cast<std::size_t>(x0); x < static_cast<std::size_t>(x1); ++x) {
        const double px = static_cast<double>(x) + 0.5, py = static_cast<double>(y) + 0.5;
        const double wa = ((b.x() - px) * (c.y() - py) - (b.y() - py) * (c.x() - px)) / normal.z();
        const double wb = ((c.x() - px) * (a.y() - py) - (c.y() - py) * (a.x() - px)) / normal.z();
        const double wc = 1 - wa - wb;
        if (wa < 0 || wb < 0 || wc < 0) continue;
        const double z = wa * a.z() + wb * b.z() + wc * c.z();
        const std::size_t at = y * width + x;
        if (z <= depth[at]) continue;
        depth[at] = z;
        for (std::size_t k = 0; k < 3; ++k) {
          const double color =
              mesh.colors.empty() ? 255 : wa * mesh.colors[ia][k] + wb * mesh.colors[ib][k] + wc * mesh.colors[ic][k];
          picture.pixels[at][k] = static_cast<std::uint8_t>(std::lround(std::clamp(light * color, 0.0, 255.0)));
        }
      }
  };
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) for_each_triangle(mesh.faces[f], draw_triangle);
  return picture;
}

std::string to_bitmap(const Picture& picture) {
  const std::size_t row = (3 * picture.width + 3) / 4 * 4, header = 54;
  std::string bytes = "BM";
  const auto number = [&bytes](std::size_t value, int count) {
    for (int k = 0; k < count; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xFF);
  };
  number(header + row * picture.height, 4);
  number(0, 4);
  number(header, 4);
  number(40, 4);
  number(picture.width, 4);
  number(picture.height, 4);
  number(1, 2);
  number(24, 2);
  for (int k = 0; k < 6; ++k) number(0, 4);
  for (std::size_t y = picture.height; y-- > 0;) {
    for (std::size_t x = 0; x < picture.width; ++x)
      for (std::size_t k = 3; k-- > 0;) bytes += static_cast<char>(picture.pixels[y * picture.width + x][k]);
    bytes.append(row - 3 * picture.width, '\0');
  }
  return bytes;
}

}  // namespace gpsrecon::internal
