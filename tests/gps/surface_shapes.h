#pragma once

#include <gpsrecon/core/surface_rules.h>
#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "support/meshes.h"

namespace gpsrecon::test {

/// A control mesh and the surface it stands for.
struct Shape {
  std::string name;
  Mesh mesh;
  SurfaceRules rules;
};

inline void PrintTo(const Shape& shape, std::ostream* out) {
  *out << shape.name;
}

/// Two triangles back to back: vertices of valence two.
inline Mesh pillow() {
  return mesh_of({{0, 0, 0}, {1, 0, 0.1}, {0, 1, 0.2}}, {{0, 1, 2}, {0, 2, 1}});
}

inline std::vector<Shape> all_shapes() {
  std::vector<Shape> shapes;
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp}) {
    const std::string rule = corners == CornerRule::smooth ? "_smooth" : "_sharp";
    const SurfaceRules triangles{.corners = corners}, quads{.scheme = Scheme::catmull_clark, .corners = corners};
    shapes.push_back({"triangle" + rule, mesh_of({{0, 0, 0}, {1, 0, 0.1}, {0, 1, 0.2}}, {{0, 1, 2}}), triangles});
    shapes.push_back({"grid" + rule, shaken(grid(5, 4), 6), triangles});
    shapes.push_back({"strip" + rule, shaken(grid(4, 1), 7), triangles});
    for (const Index n : {2, 3, 4, 5, 6, 7, 12})
      shapes.push_back({"open_fan_" + std::to_string(n) + rule, fan(n, false, n), triangles});
    shapes.push_back({"quad" + rule, shaken(quad_grid(1, 1), 8), quads});
    shapes.push_back({"pentagon" + rule, mesh_of(fan(5, true, 4).positions, {{1, 2, 3, 4, 5}}), quads});
    shapes.push_back({"quad_grid" + rule, shaken(quad_grid(4, 3), 9), quads});
    shapes.push_back({"quad_strip" + rule, shaken(quad_grid(4, 1), 10), quads});
    shapes.push_back({"mixed" + rule, mixed_polygons(), quads});
    for (const Index n : {2, 3, 4, 5, 7})
      shapes.push_back({"open_quad_fan_" + std::to_string(n) + rule, quad_fan(n, false, n), quads});
  }
  for (const Index n : {3, 4, 5, 6, 7, 12, 64})
    shapes.push_back({"closed_fan_" + std::to_string(n), fan(n, true, n), {}});
  for (const Index n : {3, 4, 5, 6, 12, 64})
    shapes.push_back({"closed_quad_fan_" + std::to_string(n), quad_fan(n, true, n), {.scheme = Scheme::catmull_clark}});
  shapes.push_back({"open_fan_64", fan(64, false, 64), {}});
  shapes.push_back({"open_quad_fan_64", quad_fan(64, false, 64), {.scheme = Scheme::catmull_clark}});
  shapes.push_back({"pillow", pillow(), {}});
  shapes.push_back({"tetrahedron", tetrahedron(), {}});
  shapes.push_back({"octahedron", octahedron(), {}});
  shapes.push_back({"torus", torus(7, 5), {}});
  shapes.push_back({"irregular", irregular_sphere(3), {}});
  shapes.push_back({"holes", with_holes(irregular_sphere(4), 11), {}});
  shapes.push_back({"isolated", with_isolated_vertex(octahedron()), {}});
  shapes.push_back({"warren", irregular_sphere(5), {.weights = LoopWeights::warren}});
  shapes.push_back({"cube", cube(), {.scheme = Scheme::catmull_clark}});
  shapes.push_back({"quad_isolated", with_isolated_vertex(cube()), {.scheme = Scheme::catmull_clark}});
  shapes.push_back({"quad_pillow",
                    mesh_of({{0, 0, 0}, {1, 0, 0.1}, {1, 1, 0.3}, {0, 1, 0.2}}, {{0, 1, 2, 3}, {3, 2, 1, 0}}),
                    {.scheme = Scheme::catmull_clark}});
  shapes.push_back({"triangles_as_polygons", irregular_sphere(6, 20), {.scheme = Scheme::catmull_clark}});
  return shapes;
}

inline std::string name_of(const testing::TestParamInfo<Shape>& info) {
  return info.param.name;
}

}  // namespace gpsrecon::test
