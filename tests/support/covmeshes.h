#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/gps/limit_surface.h>

#include <numbers>

#include "support/meshes.h"
#include "support/shapes.h"

/// Covariance meshes, and points to fit them to.
namespace gpsrecon::test {

/// A mesh with these covariances, all weights one; with equal ones; with random ones of variances in [low, high).
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
  Random random(seed);
  std::vector<Sym3> covariances;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) covariances.push_back(random.covariance(low, high));
  return covariance_mesh(mesh, covariances);
}

/// The same mesh with other rules for its surface.
inline CovMesh with_rules(CovMesh mesh, const SurfaceRules& rules) {
  mesh.rules = rules;
  return mesh;
}

/// Discs tangent to the unit sphere at the vertices of a triangulated sphere of radius `radius`.
inline CovMesh sphere_mesh(int level, double radius) {
  const Mesh round = sphere(level);
  const double edge = std::sqrt(4 * std::numbers::pi / static_cast<double>(round.positions.size()));
  std::vector<Sym3> covariances;
  for (const Vec3& n : round.positions) covariances.push_back(disc_covariance(n, 0.5 * edge, 0.1 * edge));
  CovMesh mesh = covariance_mesh(round, covariances);
  for (Vec3& mean : mesh.vertices.means) mean *= radius;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.vertices.weights[v] = 1 + 0.25 * static_cast<double>(v % 7);
  return mesh;
}

/// Points on the unit sphere with Gaussian noise.
inline PointCloud sphere_cloud(std::size_t n, double noise = 0) {
  SampledShape shape = fibonacci_sphere(n);
  add_noise(shape, noise, 5);
  return shape.cloud();
}

/// Equilateral triangles of unit edges over about cells × cells in the plane z = 0, moved by `place`, with discs in it.
template <class Place>
CovMesh lattice(Index cells, const Place& place) {
  Mesh mesh;
  std::vector<Sym3> covariances;
  for (Index j = 0; j <= cells; ++j)
    for (Index i = 0; i <= cells; ++i) {
      const double x = i + 0.5 * j - 0.75 * cells, y = std::sqrt(0.75) * (j - 0.5 * cells);
      const auto [position, normal] = place(x, y);
      mesh.positions.push_back(position);
      covariances.push_back(disc_covariance(normal, 0.5, 0.05));
    }
  const auto at = [cells](Index i, Index j) { return j * (cells + 1) + i; };
  for (Index j = 0; j < cells; ++j)
    for (Index i = 0; i < cells; ++i) {
      mesh.faces.add(at(i, j), at(i + 1, j), at(i, j + 1));
      mesh.faces.add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return covariance_mesh(mesh, covariances);
}
inline CovMesh flat_lattice(Index cells) {
  return lattice(cells, [](double x, double y) { return std::pair(Vec3(x, y, 0), Vec3(0, 0, 1)); });
}

/// Root mean square of `distance` over the samples of the limit surface.
template <class Distance>
double rms_of_surface(const CovMesh& mesh, const Distance& distance) {
  const internal::LimitSurface surface(mesh.faces, mesh.vertices.size(), 3, mesh.rules);
  double sum = 0;
  const internal::SurfaceSamples samples = surface.evaluate(mesh.vertices);
  for (const Vec3& p : samples.positions) sum += distance(p) * distance(p);
  return std::sqrt(sum / static_cast<double>(samples.positions.size()));
}
inline double rms_to_unit_sphere(const CovMesh& mesh) {
  return rms_of_surface(mesh, [](const Vec3& p) { return p.norm() - 1; });
}

}  // namespace gpsrecon::test
