#pragma once

#include <gpsrecon/core/mesh.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <stdexcept>

#include "support/random_sequence.h"

namespace gpsrecon::test {

using namespace internal;

inline Mesh make_mesh(std::vector<Vec3> positions, const std::vector<std::array<Index, 3>>& triangles) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  for (const auto& t : triangles) mesh.faces.add(t[0], t[1], t[2]);
  return mesh;
}

/// The same mesh with other rules for its surface.
inline CovMesh with_rules(CovMesh mesh, const SurfaceRules& rules) {
  mesh.rules = rules;
  return mesh;
}

inline Mesh tetrahedron() {
  return make_mesh({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
}

inline Mesh octahedron() {
  return make_mesh({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
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
  const Mesh base = sphere(1);
  std::vector<std::array<Index, 3>> triangles;
  for (std::size_t f = 0; f < base.faces.size(); ++f)
    triangles.push_back({base.faces[f][0], base.faces[f][1], base.faces[f][2]});
  std::vector<Vec3> positions = base.positions;
  RandomSequence random(seed);
  for (std::size_t s = 0; s < splits; ++s) {
    const std::size_t f = random.below(triangles.size());
    const auto [a, b, c] = triangles[f];
    const auto m = static_cast<Index>(positions.size());
    positions.push_back((positions[a] + positions[b] + positions[c]).normalized() *
                        random.uniform(1 - roughness, 1 + roughness));
    triangles[f] = {a, b, m};
    triangles.push_back({b, c, m});
    triangles.push_back({c, a, m});
  }
  return make_mesh(std::move(positions), triangles);
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
  RandomSequence random(seed);
  Mesh mesh;
  mesh.positions.push_back(0.1 * random.vector());
  const Index ring = closed ? n : n + 1;
  const double step = (closed ? 2 : 1) * std::numbers::pi / n;
  for (Index j = 0; j < ring; ++j)
    mesh.positions.push_back(Vec3(std::cos(step * j), std::sin(step * j), 0) + 0.1 * random.vector());
  for (Index j = 0; j < n; ++j) mesh.faces.add(0, 1 + j, 1 + (j + 1) % ring);
  return mesh;
}

inline CovMesh covariance_mesh(const Mesh& mesh, const std::vector<Sym3>& covariances) {
  CovMesh result;
  result.vertices.means = mesh.positions;
  result.vertices.covariances = covariances;
  result.vertices.weights.assign(mesh.positions.size(), 1);
  result.faces = mesh.faces;
  return result;
}

inline CovMesh with_equal_covariances(const Mesh& mesh, const Sym3& covariance) {
  return covariance_mesh(mesh, std::vector<Sym3>(mesh.positions.size(), covariance));
}

inline CovMesh with_random_covariances(const Mesh& mesh, std::uint64_t seed, double low = 0.01, double high = 1) {
  RandomSequence random(seed);
  std::vector<Sym3> covariances;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) covariances.push_back(random.covariance(low, high));
  return covariance_mesh(mesh, covariances);
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

inline double area(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    const Vec3& a = mesh.positions[face[0]];
    sum += 0.5 * (mesh.positions[face[1]] - a).cross(mesh.positions[face[2]] - a).norm();
  }
  return sum;
}

inline double volume(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    sum += mesh.positions[face[0]].dot(mesh.positions[face[1]].cross(mesh.positions[face[2]])) / 6;
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
