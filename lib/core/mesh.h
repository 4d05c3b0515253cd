#pragma once

#include <gpsrecon/core/frame.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/surface_rules.h>
#include <cstdint>
#include <span>
#include <vector>

namespace gpsrecon {

/// Polygons as one flat list of corners: the corners of face f are corners[offsets[f] .. offsets[f + 1]).
struct FaceList {
  std::vector<std::uint32_t> offsets{0};
  std::vector<Index> corners;

  std::size_t size() const { return offsets.size() - 1; }
  bool empty() const { return size() == 0; }
  std::span<const Index> operator[](std::size_t f) const {
    return {corners.data() + offsets[f], corners.data() + offsets[f + 1]};
  }
  void add(std::span<const Index> face) {
    corners.insert(corners.end(), face.begin(), face.end());
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  void add(Index a, Index b, Index c) {
    corners.insert(corners.end(), {a, b, c});
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  void reserve(std::size_t faces, std::size_t corner_count) {
    offsets.reserve(faces + 1);
    corners.reserve(corner_count);
  }
  /// True if every face has three corners.
  bool is_triangular() const { return corners.size() == 3 * size() && all_of_size(3); }
  bool all_of_size(std::uint32_t n) const {
    for (std::size_t f = 0; f < size(); ++f)
      if (offsets[f + 1] - offsets[f] != n) return false;
    return true;
  }
  friend bool operator==(const FaceList&, const FaceList&) = default;
};

/// A polygon mesh. Every attribute is empty or one per vertex.
struct Mesh {
  std::vector<Vec3> positions;
  FaceList faces;
  std::vector<Vec3> normals;
  std::vector<Color> colors;
  std::vector<double> sigma;      ///< standard deviation along the normal without the kernel, in units of `positions`
  std::vector<Sym3> covariances;  ///< of the Gaussians there, in units of `positions` squared
  std::vector<ScalarColumn> scalars;
  Frame frame;
};

/// A covariance mesh (Preiner et al. 2019, section 3): a polygon mesh whose vertices are the components of a mixture,
/// and the rules by which it stands for a smooth surface.
struct CovMesh {
  Mixture vertices;
  FaceList faces;
  SurfaceRules rules = {};
};

/// The rules of a control mesh of which nothing else is known: Loop's scheme for triangles, Catmull and Clark's for
/// other polygons. O(faces).
SurfaceRules rules_for(const FaceList& faces);

/// Throws InvariantError unless every face has three corners or more, all different and below vertex_count.
void validate(const FaceList& faces, std::size_t vertex_count);

/// Throws InvariantError, naming the element, unless positions are finite, attributes match in length, corners are
/// valid and no face repeats a corner. Manifoldness is not required of a Mesh. O(n).
void validate(const Mesh& mesh);

/// As above, and: the vertices form a valid mixture, and the faces are edge-manifold, vertex-manifold and consistently
/// oriented, and triangles if the scheme is Loop's. Boundaries and several components are allowed. O(n).
void validate(const CovMesh& mesh);

}  // namespace gpsrecon
