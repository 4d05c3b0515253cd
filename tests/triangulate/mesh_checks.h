#pragma once

#include <gpsrecon/core/mesh_topology.h>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <tuple>
#include <vector>

namespace gpsrecon::test {

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

/// Enclosed volume; positive if the faces are oriented outward.
inline double signed_volume(const FaceList& faces, const std::vector<Vec3>& positions) {
  double volume = 0;
  for (std::size_t f = 0; f < faces.size(); ++f)
    volume += positions[faces[f][0]].dot(area_vector(faces, f, positions)) / 3;
  return volume;
}

}  // namespace gpsrecon::test
