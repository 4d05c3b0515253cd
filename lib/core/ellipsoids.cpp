#include <gpsrecon/core/ellipsoids.h>
#include <gpsrecon/core/error.h>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

namespace gpsrecon::internal {
namespace {

struct Sphere {
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 3>> faces;
};

Sphere icosahedron() {
  constexpr double g = std::numbers::phi;
  Sphere sphere;
  for (const auto& [a, b] : {std::pair{1.0, g}, {-1.0, g}, {1.0, -g}, {-1.0, -g}}) {
    sphere.vertices.insert(sphere.vertices.end(), {Vec3(0, a, b), Vec3(a, b, 0), Vec3(b, 0, a)});
  }
  for (Vec3& v : sphere.vertices) v.normalize();
  // The faces are the triples of mutually adjacent vertices; adjacent ones have the inner product 1/√5.
  const auto adjacent = [&](Index i, Index j) { return sphere.vertices[i].dot(sphere.vertices[j]) > 0.4; };
  for (Index i = 0; i < 12; ++i)
    for (Index j = i + 1; j < 12; ++j)
      for (Index k = j + 1; k < 12; ++k) {
        if (!adjacent(i, j) || !adjacent(j, k) || !adjacent(i, k)) continue;
        const auto& v = sphere.vertices;
        const bool outward = v[i].cross(v[j]).dot(v[k]) > 0;
        sphere.faces.push_back(outward ? std::array{i, j, k} : std::array{i, k, j});
      }
  return sphere;
}

/// Each triangle into four, new vertices pushed to the sphere.
Sphere refined(Sphere sphere) {
  std::map<std::pair<Index, Index>, Index> midpoints;
  const auto midpoint = [&](Index i, Index j) {
    const auto [at, is_new] = midpoints.emplace(std::minmax(i, j), static_cast<Index>(sphere.vertices.size()));
    if (is_new) sphere.vertices.push_back((sphere.vertices[i] + sphere.vertices[j]).normalized());
    return at->second;
  };
  std::vector<std::array<Index, 3>> faces;
  for (const auto& [a, b, c] : sphere.faces) {
    const Index ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
    faces.insert(faces.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  sphere.faces = std::move(faces);
  return sphere;
}

Color color_of_axis(const Vec3& axis) {
  Color color;
  for (int c = 0; c < 3; ++c)
    color[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, std::abs(axis[c]))));
  return color;
}

}  // namespace

Mesh ellipsoid_mesh(const Mixture& mixture, const EllipsoidOptions& options) {
  options.check();
  Sphere sphere = icosahedron();
  for (int level = 0; level < options.level; ++level) sphere = refined(std::move(sphere));

  Mesh mesh;
  mesh.frame = mixture.frame;
  mesh.positions.reserve(mixture.size() * sphere.vertices.size());
  mesh.faces.reserve(mixture.size() * sphere.faces.size(), 3 * mixture.size() * sphere.faces.size());
  for (std::size_t s = 0; s < mixture.size(); ++s) {
    const Eigen3 eigen = eigen_decomposition(mixture.covariances[s]);
    // The symmetric root keeps the orientation; U √λ alone would mirror where U does.
    const Mat3 root = eigen.vectors * eigen.values.cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.vectors.transpose();
    const auto first = static_cast<Index>(mesh.positions.size());
    for (const Vec3& u : sphere.vertices) mesh.positions.emplace_back(mixture.means[s] + options.scale * (root * u));
    for (const auto& [a, b, c] : sphere.faces) mesh.faces.add(first + a, first + b, first + c);
    if (options.colors)
      mesh.colors.insert(mesh.colors.end(), sphere.vertices.size(), color_of_axis(eigen.vectors.col(0)));
  }
  return mesh;
}

}  // namespace gpsrecon::internal
