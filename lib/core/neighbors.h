#pragma once

#include <gpsrecon/core/vec.h>
#include <memory>
#include <span>
#include <vector>

namespace gpsrecon::internal {

struct Neighbor {
  Index index;      ///< into the points the index was built from
  double distance;  ///< Euclidean, not squared

  friend bool operator<(const Neighbor& a, const Neighbor& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.index < b.index);
  }
};

/// Exact neighbour search over a fixed set of points (a kd-tree). Building is O(n log n); a query is O(log n +
/// results). Queries are const and may run in parallel; they run 2-3 times faster when consecutive queries are close in
/// space.
class Neighbors {
 public:
  /// Copies the points. An empty set is allowed and finds nothing. Throws std::bad_alloc only.
  explicit Neighbors(std::span<const Vec3> points);
  ~Neighbors();
  Neighbors(Neighbors&&) noexcept;
  Neighbors& operator=(Neighbors&&) noexcept;

  std::size_t size() const;

  /// The min(k, size()) points nearest to `query`, by ascending distance, ties by index. A point of the set itself is
  /// its own neighbour at distance 0. `found` is overwritten; its capacity is reused.
  void nearest(const Vec3& query, std::size_t k, std::vector<Neighbor>& found) const;

  /// All points at distance <= radius, by ascending index. `found` is overwritten; its capacity is reused.
  void within(const Vec3& query, double radius, std::vector<Neighbor>& found) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gpsrecon::internal
