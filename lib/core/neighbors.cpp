// A kd-tree (Friedman, Bentley & Finkel 1977), that of FLANN (Muja & Lowe 2009), exact.

#include <gpsrecon/core/neighbors.h>

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>
#include <algorithm>

namespace gpsrecon::internal {
namespace {

// FLANN accumulates lower bounds of squared distances incrementally, so they may exceed the true value by a few ulp.
// Searching this much farther, and deciding by the exact squared distance, makes ties come out right.
constexpr double slack = 1 + 1e-13;

/// The k smallest (squared distance, index) pairs, kept sorted.
class NearestSet final : public flann::ResultSet<double> {
 public:
  NearestSet(std::vector<Neighbor>& found, std::size_t k) : found_(found), k_(k) { found_.clear(); }
  bool full() const override { return found_.size() == k_; }
  double worstDist() const override {
    return full() ? found_.back().distance * slack + std::numeric_limits<double>::min()
                  : std::numeric_limits<double>::max();
  }
  void addPoint(double squared_distance, std::size_t index) override {
    const Neighbor candidate{static_cast<Index>(index), squared_distance};
    if (full()) {
      if (!(candidate < found_.back())) return;
      found_.pop_back();
    }
    std::size_t at = found_.size();
    found_.push_back(candidate);
    for (; at > 0 && candidate < found_[at - 1]; --at) found_[at] = found_[at - 1];
    found_[at] = candidate;
  }

 private:
  std::vector<Neighbor>& found_;
  std::size_t k_;
};

class BallSet final : public flann::ResultSet<double> {
 public:
  BallSet(std::vector<Neighbor>& found, double squared_radius) : found_(found), squared_radius_(squared_radius) {
    found_.clear();
  }
  bool full() const override { return true; }
  double worstDist() const override { return squared_radius_ * slack + std::numeric_limits<double>::min(); }
  void addPoint(double squared_distance, std::size_t index) override {
    if (squared_distance <= squared_radius_) found_.push_back({static_cast<Index>(index), squared_distance});
  }

 private:
  std::vector<Neighbor>& found_;
  double squared_radius_;
};

}  // namespace

struct Neighbors::Impl {
  using Tree = flann::KDTreeSingleIndex<flann::L2_3D<double>>;
  std::size_t size;
  std::unique_ptr<Tree> tree;

  explicit Impl(std::span<const Vec3> points) : size(points.size()) {
    if (points.empty()) return;
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    // FLANN only reads the data, and with `reorder` keeps a copy of its own.
    const flann::Matrix<double> data(const_cast<double*>(points.front().data()), points.size(), 3);
    tree = std::make_unique<Tree>(data, flann::KDTreeSingleIndexParams(12, true));
    tree->buildIndex();
  }

  void search(flann::ResultSet<double>& results, const Vec3& query) const {
    static const flann::SearchParams exact(flann::FLANN_CHECKS_UNLIMITED, 0.0F, false);
    if (tree) tree->findNeighbors(results, query.data(), exact);
  }
};

Neighbors::Neighbors(std::span<const Vec3> points) : impl_(std::make_unique<Impl>(points)) {}
Neighbors::~Neighbors() = default;
Neighbors::Neighbors(Neighbors&&) noexcept = default;
Neighbors& Neighbors::operator=(Neighbors&&) noexcept = default;

std::size_t Neighbors::size() const {
  return impl_->size;
}

void Neighbors::nearest(const Vec3& query, std::size_t k, std::vector<Neighbor>& found) const {
  NearestSet results(found, std::min(k, impl_->size));
  if (k == 0) return;
  impl_->search(results, query);
  for (Neighbor& n : found) n.distance = std::sqrt(n.distance);
}

void Neighbors::within(const Vec3& query, double radius, std::vector<Neighbor>& found) const {
  BallSet results(found, radius * radius);
  if (!(radius >= 0)) return;
  impl_->search(results, query);
  for (Neighbor& n : found) n.distance = std::sqrt(n.distance);
  std::sort(found.begin(), found.end(), [](const Neighbor& a, const Neighbor& b) { return a.index < b.index; });
}

}  // namespace gpsrecon::internal
