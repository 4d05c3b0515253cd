#include <gpsrecon/gps/face_normals.h>

#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/parallel.h>
#include <Eigen/Geometry>
#include <algorithm>

namespace gpsrecon::internal {

std::vector<Index> complete_normals(const FaceList& faces, const std::vector<Vec3>& positions,
                                    std::vector<Vec3>& normals, const RunContext& context) {
  std::vector<Index> missing;
  const auto zero = [&](std::size_t v) { return normals[v].isZero(0) ? std::size_t{1} : std::size_t{0}; };
  if (parallel_sum<std::size_t>(normals.size(), context, zero) == 0) return missing;
  for (Index v = 0; v < normals.size(); ++v)
    if (normals[v].isZero(0)) missing.push_back(v);
  std::vector<bool> wanted(normals.size(), false);
  for (const Index v : missing) wanted[v] = true;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    if (std::none_of(face.begin(), face.end(), [&](Index v) { return wanted[v]; })) continue;
    const Vec3 area = area_vector(positions, face);
    for (const Index v : face)
      if (wanted[v]) normals[v] += area;
  }
  for (const Index v : missing) normals[v].stableNormalize();
  return missing;
}

}  // namespace gpsrecon::internal
