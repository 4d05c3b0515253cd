#include <gpsrecon/core/in_frame.h>

#include <cmath>
#include <utility>

namespace gpsrecon {
namespace {

/// Σ scales with the square of lengths.
void scale_covariances(std::vector<Sym3>& covariances, const Frame& from, const Frame& to) {
  const double area = std::ldexp(1.0, 2 * (from.exponent - to.exponent));
  for (Sym3& c : covariances) c *= area;
}

double length_factor(const Frame& from, const Frame& to) {
  return std::ldexp(1.0, from.exponent - to.exponent);
}

}  // namespace

std::vector<Vec3> in_frame(std::vector<Vec3> positions, const Frame& from, const Frame& to) {
  if (from == to) return positions;
  for (Vec3& p : positions) p = to.to_local(from.to_world(p));
  return positions;
}

PointCloud in_frame(PointCloud cloud, const Frame& frame) {
  if (cloud.frame == frame) return cloud;
  cloud.positions = in_frame(std::move(cloud.positions), cloud.frame, frame);
  cloud.sensors = in_frame(std::move(cloud.sensors), cloud.frame, frame);
  cloud.frame = frame;
  return cloud;
}

Mixture in_frame(Mixture mixture, const Frame& frame) {
  if (mixture.frame == frame) return mixture;
  mixture.means = in_frame(std::move(mixture.means), mixture.frame, frame);
  scale_covariances(mixture.covariances, mixture.frame, frame);
  mixture.sigma0 *= length_factor(mixture.frame, frame);
  for (double& kernel : mixture.kernels) kernel *= length_factor(mixture.frame, frame);
  mixture.spacing *= length_factor(mixture.frame, frame);
  mixture.frame = frame;
  return mixture;
}

Mesh in_frame(Mesh mesh, const Frame& frame) {
  if (mesh.frame == frame) return mesh;
  mesh.positions = in_frame(std::move(mesh.positions), mesh.frame, frame);
  for (double& s : mesh.sigma) s *= length_factor(mesh.frame, frame);
  scale_covariances(mesh.covariances, mesh.frame, frame);
  mesh.frame = frame;
  return mesh;
}

CovMesh in_frame(CovMesh mesh, const Frame& frame) {
  mesh.vertices = in_frame(std::move(mesh.vertices), frame);
  return mesh;
}

}  // namespace gpsrecon
