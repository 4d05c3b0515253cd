#pragma once

#include <gpsrecon/core/mesh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "support/random.h"

/// Meshes of known shape, and what tests measure of meshes.
namespace gpsrecon::test {

/// Faces and mesh of the given corners.
inline FaceList faces_of(const std::vector<std::vector<Index>>& list) {
  FaceList faces;
  for (const auto& f : list) faces.add(f);
  return faces;
}
inline Mesh mesh_of(std::vector<Vec3> positions, const std::vector<std::vector<Index>>& faces) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  mesh.faces = faces_of(faces);
  return mesh;
}

inline Mesh tetrahedron() {
  return mesh_of({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
}

inline Mesh octahedron() {
  return mesh_of({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                 {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
}

/// The unit sphere: an octahedron refined one-to-four, every vertex on the sphere. 4^level * 8 faces.
inline Mesh sphere(int level) {
  Mesh mesh = octahedron();
  for (int l = 0; l < level; ++l) {
    Mesh fine;
    fine.positions = mesh.positions;
    std::map<std::pair<Index, Index>, Index> middle;
    const auto between = [&](Index a, Index b) {
      const auto [at, added] = middle.try_emplace(std::minmax(a, b), static_cast<Index>(fine.positions.size()));
      if (added) fine.positions.push_back((mesh.positions[a] + mesh.positions[b]).normalized());
      return at->second;
    };
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const Index a = mesh.faces[f][0], b = mesh.faces[f][1], c = mesh.faces[f][2];
      const Index ab = between(a, b), bc = between(b, c), ca = between(c, a);
      fine.faces.add(a, ab, ca);
      fine.faces.add(b, bc, ab);
      fine.faces.add(c, ca, bc);
      fine.faces.add(ab, bc, ca);
    }
    mesh = std::move(fine);
  }
  return mesh;
}

/// A closed mesh near the unit sphere with valences from 3 to far above 6: random faces of a sphere split in three, at
/// radii that differ from one by at most `roughness`.
inline Mesh irregular_sphere(std::uint64_t seed, std::size_t splits = 60, double roughness = 0.1) {
  Mesh mesh = sphere(1);
  std::vector<std::vector<Index>> triangles;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    triangles.emplace_back(face.begin(), face.end());
  }
  std::vector<Vec3>& positions = mesh.positions;
  Random random(seed);
  for (std::size_t s = 0; s < splits; ++s) {
    const std::size_t f = random.below(triangles.size());
    const Index a = triangles[f][0], b = triangles[f][1], c = triangles[f][2];
    const auto m = static_cast<Index>(positions.size());
    positions.push_back((positions[a] + positions[b] + positions[c]).normalized() *
                        random.uniform(1 - roughness, 1 + roughness));
    triangles[f] = {a, b, m};
    triangles.push_back({b, c, m});
    triangles.push_back({c, a, m});
  }
  return mesh_of(positions, triangles);
}

/// The same mesh without some of its faces, so that it has boundaries; it stays manifold because only faces whose three
/// vertices lost no other face are taken.
inline Mesh with_holes(const Mesh& mesh, std::size_t every) {
  std::vector<bool> touched(mesh.positions.size(), false);
  Mesh open;
  open.positions = mesh.positions;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    const bool removable = f % every == 0 && !touched[face[0]] && !touched[face[1]] && !touched[face[2]];
    if (!removable) {
      open.faces.add(face);
      continue;
    }
    for (const Index v : face) touched[v] = true;
  }
  return open;
}

/// A triangulated nx × ny patch of the plane z = 0 with alternating diagonals: boundary vertices of one to four faces.
inline Mesh grid(Index nx, Index ny) {
  Mesh mesh;
  for (Index y = 0; y <= ny; ++y)
    for (Index x = 0; x <= nx; ++x) mesh.positions.emplace_back(x, y, 0);
  const auto at = [nx](Index x, Index y) { return y * (nx + 1) + x; };
  for (Index y = 0; y < ny; ++y)
    for (Index x = 0; x < nx; ++x) {
      const Index a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
      if ((x + y) % 2 == 0) {
        mesh.faces.add(a, b, c);
        mesh.faces.add(a, c, d);
      } else {
        mesh.faces.add(a, b, d);
        mesh.faces.add(b, c, d);
      }
    }
  return mesh;
}

/// A torus of nu × nv vertices, all of valence six.
inline Mesh torus(Index nu, Index nv, double major = 2, double minor = 0.7) {
  Mesh mesh;
  for (Index u = 0; u < nu; ++u)
    for (Index v = 0; v < nv; ++v) {
      const double a = 2 * std::numbers::pi * u / nu, b = 2 * std::numbers::pi * v / nv;
      const double r = major + minor * std::cos(b);
      mesh.positions.emplace_back(r * std::cos(a), r * std::sin(a), minor * std::sin(b));
    }
  const auto at = [nu, nv](Index u, Index v) { return (u % nu) * nv + v % nv; };
  for (Index u = 0; u < nu; ++u)
    for (Index v = 0; v < nv; ++v) {
      mesh.faces.add(at(u, v), at(u + 1, v), at(u + 1, v + 1));
      mesh.faces.add(at(u, v), at(u + 1, v + 1), at(u, v + 1));
    }
  return mesh;
}

/// A vertex (0) in the interior of a fan of n triangles; or, open, on the boundary of a fan of n triangles.
inline Mesh fan(Index n, bool closed, std::uint64_t seed) {
  Random random(seed);
  Mesh mesh;
  mesh.positions.push_back(0.1 * random.vector());
  const Index ring = closed ? n : n + 1;
  const double step = (closed ? 2 : 1) * std::numbers::pi / n;
  for (Index j = 0; j < ring; ++j)
    mesh.positions.push_back(Vec3(std::cos(step * j), std::sin(step * j), 0) + 0.1 * random.vector());
  for (Index j = 0; j < n; ++j) mesh.faces.add(0, 1 + j, 1 + (j + 1) % ring);
  return mesh;
}

/// The same mesh, every vertex moved by up to `size` along each axis.
inline Mesh shaken(Mesh mesh, std::uint64_t seed, double size = 0.2) {
  Random random(seed);
  for (Vec3& p : mesh.positions) p += size * random.vector();
  return mesh;
}

/// The same mesh with a vertex before all others that no face has.
inline Mesh with_isolated_vertex(Mesh mesh) {
  mesh.positions.insert(mesh.positions.begin(), Vec3(7, 8, 9));
  for (Index& v : mesh.faces.corners) ++v;
  return mesh;
}

/// The cube [-1, 1]³ of quadrilaterals.
inline Mesh cube() {
  return mesh_of({{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}},
                 {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

/// A prism with a roof: pentagons at its ends, quadrilaterals, and triangles where one end is a fan.
inline Mesh house() {
  Mesh mesh = mesh_of({{0, 0, 0},
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
  Random random(seed);
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
      mesh_of({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {2, 2, 0}, {0, 2, 0}, {-1, 1, 0}, {3, -1, 0}, {2, 3, 0}, {0, 3, 0}},
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
  return mesh_of({{0, 0, 0}, {1, 0, 0.2}, {1, 1, 0}, {0, 1, 0.3}, {0.5, 0.5, 0.1}}, {{0, 1, 2, 4}, {0, 4, 2, 3}});
}

/// Polygon meshes of every kind: boundaries, corners, faces and vertices of many sizes, from valence three on.
inline std::map<std::string, Mesh> polygon_shapes() {
  return {{"cube", cube()},
          {"house", house()},
          {"grid", shaken(quad_grid(3, 2), 9)},
          {"one quad", shaken(quad_grid(1, 1), 8)},
          {"pentagon", mesh_of(fan(5, true, 4).positions, {{1, 2, 3, 4, 5}})},
          {"40-gon", mesh_of(fan(40, true, 4).positions, {[] {
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

/// The unit square at height z, of one quadrilateral that faces up.
inline Mesh square(double z) {
  Mesh mesh;
  mesh.positions = {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}};
  mesh.faces.add(std::array<Index, 4>{0, 1, 2, 3});
  return mesh;
}

/// The box [0, x] × [0, y] × [0, z] of quadrilaterals that face outward; the last one is the lid.
inline Mesh quad_box(double x, double y, double z) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {x, 0, 0}, {x, y, 0}, {0, y, 0}, {0, 0, z}, {x, 0, z}, {x, y, z}, {0, y, z}};
  for (const std::array<Index, 4>& f : std::initializer_list<std::array<Index, 4>>{
           {0, 3, 2, 1}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}})
    mesh.faces.add(f);
  return mesh;
}

/// A torus of n × m quadrilaterals that face outward.
inline Mesh quad_torus(Index n, Index m, double big, double small) {
  Mesh mesh;
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < m; ++j) {
      const double u = 2 * M_PI * i / n, v = 2 * M_PI * j / m, r = big + small * std::cos(v);
      mesh.positions.push_back({r * std::cos(u), r * std::sin(u), small * std::sin(v)});
    }
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < m; ++j) {
      const Index i1 = (i + 1) % n, j1 = (j + 1) % m;
      mesh.faces.add(std::array<Index, 4>{i * m + j, i1 * m + j, i1 * m + j1, i * m + j1});
    }
  return mesh;
}

/// The same mesh with its faces the other way round.
inline Mesh flipped(const Mesh& mesh) {
  Mesh result = mesh;
  result.faces = {};
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    result.faces.add(std::vector<Index>(face.rbegin(), face.rend()));
  }
  return result;
}

/// The same mesh in another place.
inline Mesh moved(Mesh mesh, const Eigen::Isometry3d& motion) {
  for (Vec3& p : mesh.positions) p = motion * p;
  return mesh;
}

/// A rotation and a shift that leave no axis as it was.
inline Eigen::Isometry3d some_motion() {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  motion.translation() = Vec3(0.3, -1.1, 2.4);
  return motion;
}

/// Reads the simplest OFF dialect.
inline Mesh read_plain_off(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string magic;
  std::size_t vertices = 0, faces = 0, edges = 0;
  file >> magic >> vertices >> faces >> edges;
  if (magic != "OFF") throw std::runtime_error(path.string() + " is not an OFF file");
  Mesh mesh;
  mesh.positions.resize(vertices);
  for (Vec3& p : mesh.positions) file >> p.x() >> p.y() >> p.z();
  for (std::size_t f = 0; f < faces; ++f) {
    std::size_t n = 0;
    file >> n;
    std::vector<Index> face(n);
    for (Index& v : face) file >> v;
    mesh.faces.add(face);
  }
  if (!file) throw std::runtime_error(path.string() + " ends too early");
  return mesh;
}

/// The faces after vertices at equal positions became one.
inline FaceList welded(FaceList faces, const std::vector<Vec3>& positions) {
  std::map<std::tuple<double, double, double>, Index> first;
  for (Index& v : faces.corners) {
    const Vec3& p = positions[v];
    v = first.try_emplace({p.x(), p.y(), p.z()}, v).first->second;
  }
  return faces;
}

/// Triangles with the smallest corner first and the order around kept, sorted; `name` renames the corners.
template <class Name>
std::vector<std::array<Index, 3>> canonical(const FaceList& faces, const Name& name) {
  std::vector<std::array<Index, 3>> triangles;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::array<Index, 3> t{name(faces[f][0]), name(faces[f][1]), name(faces[f][2])};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}
inline std::vector<std::array<Index, 3>> canonical(const FaceList& faces) {
  return canonical(faces, [](Index v) { return v; });
}

/// Vector area of a face.
inline Vec3 area_vector(const FaceList& faces, std::size_t f, const std::vector<Vec3>& positions) {
  const Vec3 &a = positions[faces[f][0]], &b = positions[faces[f][1]], &c = positions[faces[f][2]];
  return 0.5 * (b - a).cross(c - a);
}

/// Enclosed volume of triangles; positive if they are oriented outward.
inline double volume(const FaceList& faces, const std::vector<Vec3>& positions) {
  double sum = 0;
  for (std::size_t f = 0; f < faces.size(); ++f)
    sum += positions[faces[f][0]].dot(area_vector(faces, f, positions)) / 3;
  return sum;
}

inline double volume(const Mesh& mesh) {
  return volume(mesh.faces, mesh.positions);
}

/// Area of triangles.
inline double area(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    const Vec3& a = mesh.positions[face[0]];
    sum += 0.5 * (mesh.positions[face[1]] - a).cross(mesh.positions[face[2]] - a).norm();
  }
  return sum;
}

/// Largest distance between corresponding entries.
inline double max_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double max = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = (a[i] - b[i]).norm();
    if (!(d <= max)) max = d;  // NaN wins
  }
  return max;
}

}  // namespace gpsrecon::test
