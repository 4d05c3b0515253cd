// Greedy triangulation of Preiner et al. 2019, section 6.2, after Cohen-Steiner and Da 2004. What the paper leaves open
// and is settled here: triangles may not overlap others around their vertices; a triangle that would only
// touch a front in a vertex comes together with the neighbour that joins the two fans there.

#include <gpsrecon/triangulate/front.h>

#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/parallel.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numbers>
#include <queue>

namespace gpsrecon::internal {
namespace {

/// Cosine between a triangle and the outer side of a corner: a triangle at right angles to a crease may lean over a
/// bit.
constexpr double least_facing = -0.1;
constexpr double sector_tolerance = 1e-3;  // sine of an angle that still counts as touching, not overlapping

/// Two-dimensional coordinates in the plane of a normal.
struct Plane {
  Vec3 u, v;
  explicit Plane(const Vec3& normal) {
    u = normal.unitOrthogonal();
    v = normal.cross(u);
  }
  Eigen::Vector2d operator()(const Vec3& x) const { return {u.dot(x), v.dot(x)}; }
};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Strictly inside the sector from `start` counter-clockwise to `end` (less than half a turn). All of unit length.
bool inside_sector(const Eigen::Vector2d& x, const Eigen::Vector2d& start, const Eigen::Vector2d& end) {
  return cross(start, x) > sector_tolerance && cross(x, end) > sector_tolerance;
}

bool sectors_overlap(const Eigen::Vector2d& a0, const Eigen::Vector2d& a1, const Eigen::Vector2d& b0,
                     const Eigen::Vector2d& b1) {
  return inside_sector(b0, a0, a1) || inside_sector(b1, a0, a1) || inside_sector(a0, b0, b1) ||
         inside_sector(a1, b0, b1) || inside_sector((b0 + b1).normalized(), a0, a1) ||
         inside_sector((a0 + a1).normalized(), b0, b1);
}

}  // namespace

std::vector<Vec3> sheet_normals(const Mixture& mixture, const RunContext& context) {
  std::vector<Vec3> normals(mixture.size());
  parallel_for(mixture.size(), context, [&](std::size_t i) {
    const double kernel = mixture.kernel(i) * mixture.kernel(i);
    const Eigen3 e = eigen_decomposition(mixture.covariances[i]);
    // What never merged is the kernel, up to rounding, and has no axes of its own.
    const bool merged = e.values[1] > (1 + 1e-9) * kernel;
    const bool flat = merged && e.values[0] - kernel <= 0.25 * (e.values[1] - kernel);
    normals[i] = flat ? Vec3(e.vectors.col(0)) : Vec3::Zero();
  });
  return normals;
}

std::optional<double> TriangleJudge::log_overlap(Index a, Index b, Index c) const {
  const double *ab = graph_.find(a, b), *bc = graph_.find(b, c), *ca = graph_.find(c, a);
  if (ab == nullptr || bc == nullptr || ca == nullptr) return std::nullopt;
  return *ab + *bc + *ca;
}

/// Adding a triangle with the edges v -> next and previous -> v keeps the fans of v open or closes the only one.
bool TriangleJudge::keeps_fans(Index v, Index next, Index previous) const {
  if (!surface_.used(v)) return true;
  const bool joins_next = surface_.has(next, v), joins_previous = surface_.has(v, previous);
  if (!joins_next || !joins_previous) return surface_.can_grow(v);
  // Both edges join: either the triangle bridges two fans, or it closes one, which then must be the only one.
  Index at = previous;  // walk from v -> previous counter-clockwise; ends at `next` when both are the same fan
  std::size_t count = 0;
  for (Index t = surface_.triangle_at(v, at); t != no_index; t = surface_.triangle_at(v, at)) {
    at = surface_.third_corner(t, v, at);
    ++count;
  }
  return at != next || count == surface_.triangles_around(v).size();
}

/// The triangles around a Gaussian show its outer side. Where that is not known: a flat Gaussian belongs to one sheet,
/// so all triangles around it show the same side of it. Dihedral angles alone let a front fold back over a few
/// triangles and go on inside out.
bool TriangleJudge::turns_back(Index v, const Vec3& normal) const {
  const Vec3& outer = sheets_.outer[v];
  if (!outer.isZero(0)) return outer.dot(normal) < least_facing;
  const Vec3& sheet = sheets_.normals[v];
  double side = 0;
  for (const Index t : surface_.triangles_around(v)) side += surface_.normal(t).dot(sheet);
  return side * normal.dot(sheet) < 0;
}

bool TriangleJudge::overlaps_fan(Index v, const GrowingSurface::Triangle& triangle, const Vec3& normal) const {
  const Vec3& center = surface_.position(v);
  const Plane plane(normal);
  const std::size_t k = triangle[0] == v ? 0 : triangle[1] == v ? 1 : 2;
  const Eigen::Vector2d start = plane(surface_.position(triangle[(k + 1) % 3]) - center).normalized();
  const Eigen::Vector2d end = plane(surface_.position(triangle[(k + 2) % 3]) - center).normalized();
  for (const Index t : surface_.triangles_around(v)) {
    if (surface_.normal(t).dot(normal) <= 0) continue;  // the other side of a crease or of a thin sheet
    const GrowingSurface::Triangle& other = surface_.triangle(t);
    const std::size_t j = other[0] == v ? 0 : other[1] == v ? 1 : 2;
    const Eigen::Vector2d other_start = plane(surface_.position(other[(j + 1) % 3]) - center).normalized();
    const Eigen::Vector2d other_end = plane(surface_.position(other[(j + 2) % 3]) - center).normalized();
    if (sectors_overlap(start, end, other_start, other_end)) return true;
  }
  return false;
}

std::optional<double> TriangleJudge::dihedral(Index a, Index b, Index c) const {
  if (surface_.has(a, b) || surface_.has(b, c) || surface_.has(c, a)) return std::nullopt;
  if (!keeps_fans(a, b, c) || !keeps_fans(b, c, a) || !keeps_fans(c, a, b)) return std::nullopt;
  const Vec3 normal = surface_.unit_normal(a, b, c);
  if (normal.isZero(0)) return std::nullopt;
  double smallest = std::numbers::pi;
  for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
    const Index t = surface_.triangle_at(to, from);
    if (t == no_index) continue;
    const double angle = std::numbers::pi - std::acos(std::clamp(normal.dot(surface_.normal(t)), -1.0, 1.0));
    smallest = std::min(smallest, angle);
  }
  if (smallest <= min_dihedral_) return std::nullopt;
  if (lenient_) return smallest;
  const GrowingSurface::Triangle triangle{a, b, c};
  for (const Index v : triangle)
    if (turns_back(v, normal) || overlaps_fan(v, triangle, normal)) return std::nullopt;
  return smallest;
}

namespace {

/// The best triangle at an edge of the front, perhaps with the one that joins the fans it would leave touching.
struct Candidate {
  double grade = -1;  ///< P = BC_ij BC_jk BC_ik β/π, Eq. 22; negative = none
  Index apex = no_index;
  GrowingSurface::Triangle ear{no_index, no_index, no_index};  ///< no_index corners = none needed

  bool exists() const { return grade >= 0; }
  bool has_ear() const { return ear[0] != no_index; }
};

struct FrontEdge {
  double grade;
  Index from, to;

  friend bool operator<(const FrontEdge& a, const FrontEdge& b) {  // for a queue that yields the best grade first
    if (a.grade != b.grade) return a.grade < b.grade;
    return std::pair(a.from, a.to) > std::pair(b.from, b.to);
  }
};

class Front {
 public:
  Front(GrowingSurface& surface, const OverlapGraph& graph, const Sheets& sheets, const TriangulateOptions& options,
        const RunContext& context)
      : surface_(surface),
        graph_(graph),
        sheets_(sheets),
        options_(options),
        context_(context),
        judge_(graph, sheets, surface, radians(options.min_dihedral)) {}

  void grow() {
    constexpr std::size_t worth_revisiting = 64;
    std::size_t revisited = 0;
    for (const Seed& seed : seeds()) {
      if (!plant(seed)) continue;
      advance();
      if (added_ - revisited < worth_revisiting) continue;
      revisit();
      revisited = added_;
    }
    revisit();
  }

 private:
  struct Seed {
    double log_overlap;
    GrowingSurface::Triangle triangle;
  };

  /// Per component the triangle with the greatest overlap among its nearest links, best first.
  std::vector<Seed> seeds() const {
    constexpr std::size_t nearest = 8;
    std::vector<Seed> found;
    std::vector<OverlapGraph::Link> links;
    for (Index i = 0; i + 1 < graph_.offset.size(); ++i) {
      links.assign(graph_[i].begin(), graph_[i].end());
      const std::size_t count = std::min(nearest, links.size());
      std::partial_sort(links.begin(), links.begin() + static_cast<std::ptrdiff_t>(count), links.end(),
                        [](const auto& a, const auto& b) {
                          return a.log_overlap != b.log_overlap ? a.log_overlap > b.log_overlap : a.to < b.to;
                        });
      Seed best{-std::numeric_limits<double>::infinity(), {}};
      for (std::size_t j = 0; j < count; ++j)
        for (std::size_t k = j + 1; k < count; ++k) {
          const double* jk = graph_.find(links[j].to, links[k].to);
          if (jk == nullptr) continue;
          const double log_overlap = links[j].log_overlap + links[k].log_overlap + *jk;
          if (log_overlap > best.log_overlap) best = {log_overlap, {i, links[j].to, links[k].to}};
        }
      if (best.log_overlap > -std::numeric_limits<double>::infinity()) found.push_back(best);
    }
    std::sort(found.begin(), found.end(), [](const Seed& a, const Seed& b) {
      return a.log_overlap != b.log_overlap ? a.log_overlap > b.log_overlap : a.triangle < b.triangle;
    });
    return found;
  }

  /// Starts a new piece of surface on three unused vertices, outer side up, or else oriented like the surface around
  /// it, if there is any.
  bool plant(const Seed& seed) {
    auto [a, b, c] = seed.triangle;
    for (const Index v : seed.triangle)
      if (surface_.used(v)) return false;
    const Vec3 normal = surface_.unit_normal(a, b, c);
    if (normal.isZero(0)) return false;
    double agreement = 0;
    for (const Index v : seed.triangle) agreement += normal.dot(sheets_.outer[v]);
    if (agreement == 0) agreement = agreement_around(seed.triangle, normal);
    if (agreement < 0) std::swap(b, c);
    add({a, b, c});
    return true;
  }

  /// How far the surface around a triangle shows the side of the normal.
  double agreement_around(const GrowingSurface::Triangle& triangle, const Vec3& normal) const {
    double agreement = 0;
    for (const Index v : triangle)
      for (const OverlapGraph::Link& link : graph_[v])
        for (const Index t : surface_.triangles_around(link.to))
          agreement += std::exp(link.log_overlap) * normal.dot(surface_.normal(t));
    return agreement;
  }

  void advance() {
    while (!queue_.empty()) {
      const FrontEdge edge = queue_.top();
      queue_.pop();
      if (!surface_.on_front(edge.from, edge.to)) continue;
      const Candidate best = grade(edge.from, edge.to);
      if (!best.exists()) continue;
      if (best.grade < edge.grade) {
        queue_.push({best.grade, edge.from, edge.to});
        continue;
      }
      add({edge.to, edge.from, best.apex});
      if (best.has_ear()) add(best.ear);
    }
  }

  /// Edges that had no admissible triangle may have one since their surroundings changed.
  void revisit() {
    for (std::size_t before = added_ + 1; before != added_;) {
      before = added_;
      for (Index t = 0; t < surface_.triangle_slots(); ++t) {
        const GrowingSurface::Triangle corners = surface_.triangle(t);
        for (std::size_t k = 0; k < 3; ++k) push(corners[k], corners[(k + 1) % 3]);
      }
      advance();
    }
  }

  void add(const GrowingSurface::Triangle& t) {
    surface_.add(t);
    ++added_;
    for (std::size_t k = 0; k < 3; ++k) push(t[k], t[(k + 1) % 3]);
    if (added_ % 256 != 0) return;
    context_.progress("triangulate",
                      std::min(1.0, 0.5 * static_cast<double>(added_) / static_cast<double>(surface_.vertex_count())));
    if (options_.on_snapshot && added_ % 2048 == 0) options_.on_snapshot(added_, surface_.faces());
  }

  void push(Index from, Index to) {
    if (from == no_index || !surface_.on_front(from, to)) return;
    const Candidate best = grade(from, to);
    if (best.exists()) queue_.push({best.grade, from, to});
  }

  /// The best admissible triangle (to, from, apex) on the open side of a front edge.
  Candidate grade(Index from, Index to) {
    const double* base = graph_.find(from, to);
    if (base == nullptr) return {};
    choices_.clear();
    const auto row_a = graph_[from], row_b = graph_[to];
    for (auto a = row_a.begin(), b = row_b.begin(); a != row_a.end() && b != row_b.end();) {
      if (a->to < b->to) {
        ++a;
      } else if (b->to < a->to) {
        ++b;
      } else {
        choices_.push_back({a->log_overlap + b->log_overlap + *base, a->to});
        ++a, ++b;
      }
    }
    std::sort(choices_.begin(), choices_.end(), [](const Choice& a, const Choice& b) {
      return a.log_overlap != b.log_overlap ? a.log_overlap > b.log_overlap : a.apex < b.apex;
    });
    Candidate best;
    for (const Choice& choice : choices_) {
      const double bound = std::exp(choice.log_overlap);  // the angle can only lower it
      if (bound <= best.grade) break;
      const auto angle = judge_.dihedral(to, from, choice.apex);
      if (!angle) continue;
      Candidate candidate{bound * *angle / std::numbers::pi, choice.apex, {no_index, no_index, no_index}};
      if (candidate.grade <= best.grade) continue;
      const bool touches_only =
          surface_.used(choice.apex) && !surface_.has(choice.apex, from) && !surface_.has(to, choice.apex);
      if (touches_only && !find_ear(from, to, candidate)) continue;
      if (candidate.grade <= best.grade) continue;
      best = candidate;
    }
    return best;
  }

  /// For a triangle that reaches the front only in its apex: the triangle beside it that joins the two fans there.
  /// Lowers the candidate's grade to the ear's if that is smaller.
  bool find_ear(Index from, Index to, Candidate& candidate) {
    const Index apex = candidate.apex;
    surface_.fans(apex, fans_);
    const Index added = surface_.add({to, from, apex});
    double best = -1;
    const auto consider = [&](Index a, Index b, Index c) {
      if (a == b || b == c || c == a) return;
      const auto log_overlap = judge_.log_overlap(a, b, c);
      if (!log_overlap) return;
      const auto angle = judge_.dihedral(a, b, c);
      if (!angle) return;
      const double grade = std::exp(*log_overlap) * *angle / std::numbers::pi;
      if (grade <= best) return;
      best = grade;
      candidate.ear = {a, b, c};
    };
    for (const GrowingSurface::Fan& fan : fans_) {
      if (fan.closed()) continue;
      consider(apex, from, fan.first);  // beside from -> apex, under apex -> first
      consider(to, apex, fan.last);     // beside apex -> to, under last -> apex
    }
    surface_.remove(added);
    if (best < 0) return false;
    candidate.grade = std::min(candidate.grade, best);
    return true;
  }

  struct Choice {
    double log_overlap;
    Index apex;
  };

  GrowingSurface& surface_;
  const OverlapGraph& graph_;
  const Sheets& sheets_;
  const TriangulateOptions& options_;
  const RunContext& context_;
  TriangleJudge judge_;
  std::priority_queue<FrontEdge> queue_;
  std::vector<Choice> choices_;
  std::vector<GrowingSurface::Fan> fans_;
  std::size_t added_ = 0;
};

}  // namespace

void grow_front(GrowingSurface& surface, const OverlapGraph& graph, const Sheets& sheets,
                const TriangulateOptions& options, const RunContext& context) {
  Front(surface, graph, sheets, options, context).grow();
}

}  // namespace gpsrecon::internal
