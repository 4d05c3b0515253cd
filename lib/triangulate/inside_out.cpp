#include <gpsrecon/triangulate/inside_out.h>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace gpsrecon {
namespace {

/// Normals at a larger angle say little about each other's sign.
constexpr double parallel = 0.7;
/// Smaller patches are left to the closing of pinholes.
constexpr std::size_t min_patch = 8;

/// Disjoint sets whose members have a sign relative to each other.
class SignedSets {
 public:
  explicit SignedSets(std::size_t n) : parent_(n), sign_(n, 1) { std::iota(parent_.begin(), parent_.end(), Index{0}); }

  struct Root {
    Index set;
    int sign;  ///< of the member relative to the root
  };
  Root find(Index v) {
    Index root = v;
    int sign = 1;
    while (parent_[root] != root) sign *= sign_[root], root = parent_[root];
    for (Index at = v, next; at != root; at = next) {  // path compression
      next = parent_[at];
      const int below = sign_[at];
      parent_[at] = root;
      sign_[at] = sign;
      sign *= below;
    }
    return {root, sign_[v]};
  }
  void join(Index a, Index b, int sign) {
    const Root ra = find(a), rb = find(b);
    if (ra.set == rb.set) return;
    parent_[rb.set] = ra.set;
    sign_[rb.set] = ra.sign * rb.sign * sign;
  }

 private:
  std::vector<Index> parent_;
  std::vector<int> sign_;
};

/// Per component: 1 if the triangles around it show the side that most of its tree shows, -1 the other, 0 unknown.
std::vector<int> agreement(const GrowingSurface& surface, const OverlapGraph& graph,
                           const std::vector<Vec3>& sheet_normals) {
  struct Relation {
    double log_overlap;
    Index a, b;
    int sign;
  };
  const std::size_t n = sheet_normals.size();
  const auto known = [&](Index v) { return surface.used(v) && !sheet_normals[v].isZero(0); };
  std::vector<Relation> relations;
  for (Index a = 0; a < n; ++a) {
    if (!known(a)) continue;
    for (const OverlapGraph::Link& link : graph[a]) {
      if (link.to <= a || !known(link.to)) continue;
      const double cosine = sheet_normals[a].dot(sheet_normals[link.to]);
      if (std::abs(cosine) > parallel)
        relations.push_back({link.log_overlap + std::log(std::abs(cosine)), a, link.to, cosine < 0 ? -1 : 1});
    }
  }
  std::sort(relations.begin(), relations.end(), [](const Relation& x, const Relation& y) {
    if (x.log_overlap != y.log_overlap) return x.log_overlap > y.log_overlap;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  SignedSets sets(n);
  for (const Relation& r : relations) sets.join(r.a, r.b, r.sign);

  std::vector<int> shown(n, 0);
  std::vector<long> balance(n, 0);
  for (Index v = 0; v < n; ++v) {
    if (!known(v)) continue;
    double side = 0;
    for (const Index t : surface.triangles_around(v)) side += surface.normal(t).dot(sheet_normals[v]);
    const SignedSets::Root root = sets.find(v);
    shown[v] = side * root.sign < 0 ? -1 : 1;
    balance[root.set] += shown[v];
  }
  for (Index v = 0; v < n; ++v)
    if (shown[v] != 0 && balance[sets.find(v).set] < 0) shown[v] = -shown[v];
  return shown;
}

}  // namespace

std::size_t turn_inside_out(GrowingSurface& surface, const OverlapGraph& graph,
                            const std::vector<Vec3>& sheet_normals) {
  const std::vector<int> shown = agreement(surface, graph, sheet_normals);
  const std::size_t slots = surface.triangle_slots();
  std::vector<char> wrong(slots, 0);
  for (Index t = 0; t < slots; ++t) {
    if (!surface.alive(t)) continue;
    int sum = 0;
    for (const Index v : surface.triangle(t)) sum += shown[v];
    wrong[t] = sum < 0 ? 1 : 0;
  }
  std::size_t turned = 0;
  std::vector<char> seen(slots, 0);
  for (Index first = 0; first < slots; ++first) {
    if (!wrong[first] || seen[first]) continue;
    std::vector<Index> patch{first}, neck;
    std::size_t open = 0;
    seen[first] = 1;
    for (std::size_t k = 0; k < patch.size(); ++k) {
      const GrowingSurface::Triangle corners = surface.triangle(patch[k]);
      for (std::size_t j = 0; j < 3; ++j) {
        const Index from = corners[j], to = corners[(j + 1) % 3];
        const Index other = surface.triangle_at(to, from);
        if (other == no_index) {
          ++open;
        } else if (!wrong[other]) {
          neck.push_back(from);
          neck.push_back(to);
        } else if (!seen[other]) {
          seen[other] = 1;
          patch.push_back(other);
        }
      }
    }
    // Two vertices per edge of the neck.
    if (patch.size() < min_patch || neck.size() >= open) continue;
    std::sort(neck.begin(), neck.end());
    std::vector<GrowingSurface::Triangle> kept;
    for (const Index t : patch) {
      const GrowingSurface::Triangle corners = surface.triangle(t);
      const bool at_neck = std::any_of(corners.begin(), corners.end(),
                                       [&](Index v) { return std::binary_search(neck.begin(), neck.end(), v); });
      if (!at_neck) kept.push_back({corners[0], corners[2], corners[1]});
      surface.remove(t);
    }
    for (const GrowingSurface::Triangle& t : kept) surface.add(t);
    turned += kept.size();
  }
  return turned;
}

}  // namespace gpsrecon
