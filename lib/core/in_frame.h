#pragma once

#include <gpsrecon/core/mesh.h>

namespace gpsrecon {

// The same in another frame: positions, sensors and lengths, and with them covariances, in the units of that frame. The
// world does not change, but for the rounding of positions, which is below 1e-15 of their world coordinates; normals,
// weights and scalars remain. What is in that frame already is returned bit for bit. O(n).

std::vector<Vec3> in_frame(std::vector<Vec3> positions, const Frame& from, const Frame& to);
PointCloud in_frame(PointCloud cloud, const Frame& frame);
Mixture in_frame(Mixture mixture, const Frame& frame);
Mesh in_frame(Mesh mesh, const Frame& frame);
CovMesh in_frame(CovMesh mesh, const Frame& frame);

}  // namespace gpsrecon
