#pragma once

#include <gpsrecon/core/mesh.h>
#include <array>
#include <vector>

namespace gpsrecon::internal {

/// Triangles over fixed vertices, added and removed one by one, with the adjacency that a growing front needs. Always
/// edge-manifold and consistently oriented: each half-edge belongs to at most one triangle.
class GrowingSurface {
 public:
  using Triangle = std::array<Index, 3>;

  explicit GrowingSurface(const std::vector<Vec3>& positions);

  /// Precondition: the three half-edges are free.
  Index add(const Triangle& triangle);
  void remove(Index triangle);

  /// The triangle that has the half-edge from -> to, or no_index.
  Index triangle_at(Index from, Index to) const;
  bool has(Index from, Index to) const { return triangle_at(from, to) != no_index; }
  /// from -> to belongs to a triangle and to -> from to none.
  bool on_front(Index from, Index to) const { return has(from, to) && !has(to, from); }

  bool used(Index v) const { return !around_[v].empty(); }
  const std::vector<Index>& triangles_around(Index v) const { return around_[v]; }
  const Triangle& triangle(Index t) const { return triangles_[t]; }
  const Vec3& normal(Index t) const { return normals_[t]; }
  const Vec3& position(Index v) const { return (*positions_)[v]; }
  /// Number of half-edges without opposite. O(triangles).
  std::size_t front_edges() const;
  /// Removed triangles keep their number and have no_index corners.
  std::size_t triangle_slots() const { return triangles_.size(); }
  bool alive(Index t) const { return triangles_[t][0] != no_index; }
  std::size_t vertex_count() const { return around_.size(); }

  /// The corner of triangle t that is neither a nor b.
  Index third_corner(Index t, Index a, Index b) const;

  /// A maximal run of triangles around a vertex v, counter-clockwise: v -> first is its first edge, last -> v its last
  /// one. A closed fan has first == last.
  struct Fan {
    Index first, last;
    std::size_t triangles;
    bool closed() const { return first == last; }
  };
  void fans(Index v, std::vector<Fan>& found) const;
  /// Some fan of v is open, or v is unused.
  bool can_grow(Index v) const;

  /// Zero if the three corners are on a line, to nine digits.
  Vec3 unit_normal(Index a, Index b, Index c) const;

  FaceList faces() const;

 private:
  const std::vector<Vec3>* positions_;
  std::vector<Triangle> triangles_;
  std::vector<Vec3> normals_;
  std::vector<std::vector<Index>> around_;
};

}  // namespace gpsrecon::internal
