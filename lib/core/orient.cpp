// Orientation of pieces relative to each other by solid angles: Van Oosterom & Strackee 1983, the winding number of
// Jacobson et al. 2013.

#include <gpsrecon/core/orient.h>

#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/parallel.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace gpsrecon::internal {
namespace {

/// Positive if v points up the z axis, or, at right angles to it, the y axis, or else the x axis.
double upward(const Vec3& v) {
  for (const int axis : {2, 1})
    if (std::abs(v[axis]) > 1e-6 * v.norm()) return v[axis];
  return v.x();
}

struct Pieces {
  Components components;
  std::vector<char> open;  ///< per component
};

Pieces find_pieces(const Connectivity& connectivity) {
  Pieces pieces{face_components(connectivity), {}};
  pieces.open.assign(pieces.components.count, 0);
  for (Index h = 0; h < connectivity.half_edge_count(); ++h)
    if (connectivity.opposite[h] == no_index) pieces.open[pieces.components.of_face[connectivity.face(h)]] = 1;
  return pieces;
}

/// Solid angle of a triangle seen from a point (Van Oosterom and Strackee 1983).
double solid_angle(const Vec3& from, Vec3 a, Vec3 b, Vec3 c) {
  a -= from, b -= from, c -= from;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

/// Per component, whether it is a closed one that lies inside an odd number of other closed ones. A single vertex
/// tells, by its winding numbers, which are ±1 inside and 0 outside: pieces of one surface do not cross each other.
std::vector<char> lies_inside(const Mixture& vertices, const FaceList& faces, const Pieces& pieces) {
  const std::size_t count = pieces.components.count;
  std::vector<char> inside(count, 0);
  std::vector<Index> closed, first_face(count, no_index);
  for (std::size_t f = faces.size(); f-- > 0;) first_face[pieces.components.of_face[f]] = static_cast<Index>(f);
  for (std::size_t c = 0; c < count; ++c)
    if (!pieces.open[c]) closed.push_back(static_cast<Index>(c));
  if (closed.size() < 2) return inside;
  std::vector<double> angle(count);
  for (const Index c : closed) {
    const Vec3& from = vertices.means[faces[first_face[c]][0]];
    std::fill(angle.begin(), angle.end(), 0.0);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const Index other = pieces.components.of_face[f];
      if (other == c || pieces.open[other]) continue;
      const auto t = faces[f];
      angle[other] += solid_angle(from, vertices.means[t[0]], vertices.means[t[1]], vertices.means[t[2]]);
    }
    for (const Index other : closed)
      if (std::abs(angle[other]) > 2 * std::numbers::pi) inside[c] ^= 1;
  }
  return inside;
}

/// Reverses the faces of the components marked, and counts these.
std::size_t turn_over(FaceList& faces, Connectivity& connectivity, const Components& components,
                      const std::vector<char>& marked) {
  const auto turned = static_cast<std::size_t>(std::count(marked.begin(), marked.end(), 1));
  if (turned == 0) return 0;
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (marked[components.of_face[f]])
      std::reverse(faces.corners.begin() + faces.offsets[f], faces.corners.begin() + faces.offsets[f + 1]);
  connectivity = build_connectivity(faces, connectivity.vertex_count);
  return turned;
}

}  // namespace

std::size_t orient(const Mixture& vertices, FaceList& faces, Connectivity& connectivity,
                   const std::optional<Vec3>& sensor) {
  const Pieces pieces = find_pieces(connectivity);
  const std::size_t count = pieces.components.count;
  const auto center_of = [&](std::size_t f) {
    const auto t = faces[f];
    return Vec3((vertices.means[t[0]] + vertices.means[t[1]] + vertices.means[t[2]]) / 3);
  };
  std::vector<Vec3> centroid(count, Vec3::Zero());
  std::vector<double> area(count, 0);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const double size = area_vector(vertices.means, faces[f]).norm();
    centroid[pieces.components.of_face[f]] += size * center_of(f);
    area[pieces.components.of_face[f]] += size;
  }
  std::vector<double> side(count, 0), largest(count, 0);
  std::vector<Vec3> vector_area(count, Vec3::Zero());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Index c = pieces.components.of_face[f];
    const Vec3 normal = area_vector(vertices.means, faces[f]), center = center_of(f);
    // Flux of the field from the centroid: six times the enclosed volume if closed. Towards the sensor: each face
    // votes with its area, as seen, since near faces would otherwise decide alone.
    const Vec3 out = pieces.open[c] && sensor ? (*sensor - center).normalized() : Vec3(center - centroid[c] / area[c]);
    side[c] += normal.dot(out);
    largest[c] += normal.norm() * out.norm();
    vector_area[c] += normal;
  }
  // A flat sheet has no outside, and rounding must not choose one.
  for (std::size_t c = 0; c < count; ++c)
    if (std::abs(side[c]) <= 1e-9 * largest[c]) side[c] = upward(vector_area[c]);
  std::vector<char> wrong = lies_inside(vertices, faces, pieces);
  for (std::size_t c = 0; c < count; ++c)
    if (side[c] < 0) wrong[c] ^= 1;
  return turn_over(faces, connectivity, pieces.components, wrong);
}

std::size_t orient_outward(const Mixture& vertices, FaceList& faces, Connectivity& connectivity) {
  const Components components = face_components(connectivity);
  std::vector<double> side(components.count, 0);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Vec3 normal = area_vector(vertices.means, faces[f]);
    for (const Index v : faces[f]) side[components.of_face[f]] += normal.dot(vertices.outward[v]);
  }
  std::vector<char> wrong(side.size());
  for (std::size_t c = 0; c < side.size(); ++c) wrong[c] = side[c] < 0;
  return turn_over(faces, connectivity, components, wrong);
}

std::size_t orient_by_vote(const Mixture& vertices, FaceList& faces, Connectivity& connectivity,
                           const PointCloud& cloud, std::span<const Vec3> directions, const RunContext& context) {
  const Pieces pieces = find_pieces(connectivity);
  if (std::find(pieces.open.begin(), pieces.open.end(), 1) == pieces.open.end()) return 0;
  std::vector<Vec3> normals(vertices.size(), Vec3::Zero());
  std::vector<Index> component(vertices.size(), no_index);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Vec3 normal = area_vector(vertices.means, faces[f]);
    for (const Index v : faces[f]) {
      normals[v] += normal;
      component[v] = pieces.components.of_face[f];
    }
  }
  const Neighbors index(vertices.means);
  std::vector<Index> nearest(cloud.size());
  parallel_blocks(cloud.size(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Neighbor> found;
    for (std::size_t i = begin; i < end; ++i) {
      index.nearest(cloud.positions[i], 1, found);
      nearest[i] = found.front().index;
    }
  });
  std::vector<double> votes(pieces.components.count, 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Index c = component[nearest[i]];
    if (c == no_index || !directions[i].allFinite()) continue;
    const double side = directions[i].dot(normals[nearest[i]]);
    votes[c] += side > 0 ? cloud.weight(i) : side < 0 ? -cloud.weight(i) : 0;
  }
  std::vector<char> wrong(votes.size());
  for (std::size_t c = 0; c < votes.size(); ++c) wrong[c] = pieces.open[c] && votes[c] < 0;
  return turn_over(faces, connectivity, pieces.components, wrong);
}

}  // namespace gpsrecon::internal
