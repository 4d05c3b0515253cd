#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <string>

#include "meshes.h"

namespace gpsrecon::test {

using namespace internal;

inline Mesh shaken(Mesh mesh, std::uint64_t seed, double size = 0.2) {
  RandomSequence random(seed);
  for (Vec3& p : mesh.positions) p += size * random.vector();
  return mesh;
}

inline Mesh with_isolated_vertex(Mesh mesh) {
  mesh.positions.insert(mesh.positions.begin(), Vec3(7, 8, 9));
  for (Index& v : mesh.faces.corners) ++v;
  return mesh;
}

inline Mesh polygons(std::vector<Vec3> positions, const std::vector<std::vector<Index>>& faces) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  for (const auto& f : faces) mesh.faces.add(f);
  return mesh;
}

inline Mesh cube() {
  return polygons({{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}},
                  {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

/// A prism with a roof: pentagons at its ends, quadrilaterals, and triangles where one end is a fan.
inline Mesh house() {
  Mesh mesh = polygons({{0, 0, 0},
                        {2, 0, 0},
                        {2, 0, 1},
                        {1, 0, 2},
                        {0, 0, 1},
                        {0, 3, 0},
                        {2, 3, 0},
                        {2, 3, 1},
                        {1, 3, 2},
                        {0, 3, 1},
                        {1, 3.5, 0.8}},
                       {{0, 1, 2, 3, 4},
                        {1, 0, 5, 6},
                        {2, 1, 6, 7},
                        {3, 2, 7, 8},
                        {4, 3, 8, 9},
                        {0, 4, 9, 5},
                        {6, 5, 10},
                        {7, 6, 10},
                        {8, 7, 10},
                        {9, 8, 10},
                        {5, 9, 10}});
  return mesh;
}

/// nx by ny quadrilaterals.
inline Mesh quad_grid(Index nx, Index ny) {
  Mesh mesh;
  for (Index y = 0; y <= ny; ++y)
    for (Index x = 0; x <= nx; ++x) mesh.positions.emplace_back(x, y, 0);
  for (Index y = 0; y < ny; ++y)
    for (Index x = 0; x < nx; ++x) {
      const Index a = y * (nx + 1) + x;
      mesh.faces.add(std::array{a, a + 1, a + nx + 2, a + nx + 1});
    }
  return mesh;
}

/// A vertex (0) among n quadrilaterals.
inline Mesh quad_fan(Index n, bool closed, std::uint64_t seed) {
  RandomSequence random(seed);
  Mesh mesh;
  mesh.positions.push_back(0.1 * random.vector());
  const Index spokes = closed ? n : n + 1, ring = closed ? 2 * n : 2 * n + 1;
  const double step = (closed ? 2 : 1) * std::numbers::pi / n;
  for (Index j = 0; j < ring; ++j) {
    const double radius = j % 2 == 0 ? 1 : 1.4, angle = 0.5 * step * j;
    mesh.positions.push_back(radius * Vec3(std::cos(angle), std::sin(angle), 0) + 0.1 / n * random.vector());
  }
  for (Index j = 0; j < n; ++j) mesh.faces.add(std::array{Index{0}, 1 + 2 * j, 2 + 2 * j, 1 + 2 * ((j + 1) % spokes)});
  return mesh;
}

/// A triangle, a quadrilateral, a pentagon and another quadrilateral that share vertices and leave a boundary.
inline Mesh mixed_polygons() {
  return shaken(
      polygons({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {2, 2, 0}, {0, 2, 0}, {-1, 1, 0}, {3, -1, 0}, {2, 3, 0}, {0, 3, 0}},
               {{0, 1, 3, 4}, {1, 2, 3}, {0, 4, 5}, {0, 6, 2, 1}, {4, 3, 2, 7, 8}}),
      3, 0.1);
}

/// A closed fan of n triangles around a vertex, and one below.
inline Mesh double_pyramid(Index n) {
  Mesh mesh;
  mesh.positions = {{0, 0, 1}, {0, 0, -1}};
  for (Index i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0.1 * std::cos(3 * angle));
  }
  for (Index i = 0; i < n; ++i) {
    const Index a = 2 + i, b = 2 + (i + 1) % n;
    mesh.faces.add(0, a, b);
    mesh.faces.add(1, b, a);
  }
  return mesh;
}

/// Two polygons of n corners back to back: the vertices are of valence two.
inline Mesh polygon_pillow(Index n) {
  Mesh mesh;
  std::vector<Index> face, back;
  for (Index i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0.1 * std::sin(3 * angle));
    face.push_back(i);
    back.push_back(n - 1 - i);
  }
  mesh.faces.add(face);
  mesh.faces.add(back);
  return mesh;
}

/// Two quadrilaterals that share two edges: the vertex between (4) is interior and of valence two.
inline Mesh interior_valence_two() {
  return polygons({{0, 0, 0}, {1, 0, 0.2}, {1, 1, 0}, {0, 1, 0.3}, {0.5, 0.5, 0.1}}, {{0, 1, 2, 4}, {0, 4, 2, 3}});
}

/// Polygon meshes of every kind: boundaries, corners, faces and vertices of many sizes, from valence three on.
inline std::map<std::string, Mesh> polygon_shapes() {
  return {{"cube", cube()},
          {"house", house()},
          {"grid", shaken(quad_grid(3, 2), 9)},
          {"one quad", shaken(quad_grid(1, 1), 8)},
          {"pentagon", polygons(fan(5, true, 4).positions, {{1, 2, 3, 4, 5}})},
          {"40-gon", polygons(fan(40, true, 4).positions, {[] {
                                std::vector<Index> face(40);
                                std::iota(face.begin(), face.end(), Index{1});
                                return face;
                              }()})},
          {"mixed", mixed_polygons()},
          {"open fan of 7", quad_fan(7, false, 5)},
          {"closed fan of 12", quad_fan(12, true, 6)},
          {"isolated vertex", with_isolated_vertex(cube())},
          {"tetrahedron", tetrahedron()},
          {"valence 5", double_pyramid(5)},
          {"valence 64", double_pyramid(64)}};
}

}  // namespace gpsrecon::test
