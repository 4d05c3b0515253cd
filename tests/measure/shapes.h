#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/random.h>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace gpsrecon::test {

using namespace internal;

/// Reproducible numbers for tests, uniform in [low, high).
class Uniform {
 public:
  explicit Uniform(std::uint64_t stream) : stream_(stream) {}
  double operator()(double low = 0, double high = 1) {
    return low + (high - low) * random_uniform(42, stream_, counter_++);
  }
  Vec3 vector(double low = -1, double high = 1) {
    const double x = (*this)(low, high), y = (*this)(low, high), z = (*this)(low, high);
    return {x, y, z};
  }

 private:
  std::uint64_t stream_, counter_ = 0;
};

inline Mesh octahedron() {
  Mesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (const std::array<Index, 3>& f : std::initializer_list<std::array<Index, 3>>{
           {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}})
    mesh.faces.add(f[0], f[1], f[2]);
  return mesh;
}

/// The unit sphere: an octahedron, every edge halved `level` times and pushed out. Faces outward.
inline Mesh sphere(int level) {
  Mesh mesh = octahedron();
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [entry, is_new] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<Index>(mesh.positions.size()));
      if (is_new) mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]).normalized());
      return entry->second;
    };
    FaceList faces;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const Index a = mesh.faces[f][0], b = mesh.faces[f][1], c = mesh.faces[f][2];
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      faces.add(a, ab, ca);
      faces.add(b, bc, ab);
      faces.add(c, ca, bc);
      faces.add(ab, bc, ca);
    }
    mesh.faces = std::move(faces);
  }
  return mesh;
}

/// The unit square at height z, of one quadrilateral that faces up.
inline Mesh square(double z) {
  Mesh mesh;
  mesh.positions = {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}};
  mesh.faces.add(std::array<Index, 4>{0, 1, 2, 3});
  return mesh;
}

/// The box [0, x] × [0, y] × [0, z] of quadrilaterals that face outward; the last one is the lid.
inline Mesh box(double x, double y, double z) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {x, 0, 0}, {x, y, 0}, {0, y, 0}, {0, 0, z}, {x, 0, z}, {x, y, z}, {0, y, z}};
  for (const std::array<Index, 4>& f : std::initializer_list<std::array<Index, 4>>{
           {0, 3, 2, 1}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}})
    mesh.faces.add(f);
  return mesh;
}

/// A torus of n × m quadrilaterals that face outward.
inline Mesh torus(Index n, Index m, double big, double small) {
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

inline Mesh flipped(const Mesh& mesh) {
  Mesh result = mesh;
  result.faces = {};
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto face = mesh.faces[f];
    result.faces.add(std::vector<Index>(face.rbegin(), face.rend()));
  }
  return result;
}

inline Mesh moved(Mesh mesh, const Eigen::Isometry3d& motion) {
  for (Vec3& p : mesh.positions) p = motion * p;
  return mesh;
}

inline Eigen::Isometry3d some_motion() {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  motion.translation() = Vec3(0.3, -1.1, 2.4);
  return motion;
}

}  // namespace gpsrecon::test
