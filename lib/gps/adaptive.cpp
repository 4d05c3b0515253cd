// Longest-edge bisection: Rivara 1984; distances from triangles: Ericson 2005, section 5.1.5.

#include <gpsrecon/gps/adaptive.h>

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/gps/evaluate_data.h>
#include <algorithm>
#include <array>
#include <limits>

namespace gpsrecon::internal {
namespace {

using Vec2 = Eigen::Vector2d;

/// Between the samples the surface may be farther away: by up to a third, measured where covariances vary by 20 : 1.
constexpr double safety = 0.7;
struct Edge {
  Index a, b;   ///< vertices
  Index patch;  ///< of one of the faces at it
  Vec2 pa, pb;  ///< where they are in this patch
  int halvings;
  Index middle = no_index;
  std::array<Index, 2> halves{no_index, no_index};  ///< from a to the middle, from there to b
  std::array<Index, 2> faces{no_index, no_index};   ///< triangles at it
  bool split = false;
  bool fresh = true;        ///< a triangle at it is new
  bool unresolved = false;  ///< deviates, but is too small to be split
};

struct Triangle {
  std::array<Index, 3> vertices, edges;  ///< edge i from vertex i to vertex i + 1
  Index patch;
  std::array<Vec2, 3> at;
  int generation;  ///< number of splits since the control face
  bool fresh = true;
  bool unresolved = false;
};

/// Distance of a point from a triangle (Ericson 2005, section 5.1.5).
double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.norm();
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.norm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).norm();
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.norm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).norm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return (bp - (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b)).norm();
  const double sum = va + vb + vc;
  return (ap - vb / sum * ab - vc / sum * ac).norm();
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length = ab.squaredNorm();
  const double t = length > 0 ? std::clamp(ab.dot(p - a) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

class Tessellator {
 public:
  Tessellator(const SurfaceEvaluator& surface, const ConnectedMesh& control, double tolerance, int max_halvings,
              const RunContext& context)
      : surface_(surface), limit_(safety * tolerance), max_halvings_(max_halvings), context_(context) {
    positions_ = control.mesh.vertices.means;
    parameters_.assign(positions_.size(), {no_index, 0, 0});
    triangulate_control(control.mesh.faces, control.connectivity);
    place_vertices(0);
  }

  Tessellation run() {
    for (;;) {
      context_.throw_if_cancelled();
      link_faces();
      mark_edges();
      mark_faces();
      close_marks();
      if (!split()) break;
    }
    Tessellation result;
    result.faces.reserve(triangles_.size(), 3 * triangles_.size());
    for (const Triangle& t : triangles_) result.faces.add(t.vertices[0], t.vertices[1], t.vertices[2]);
    result.parameters = std::move(parameters_);
    result.positions = std::move(positions_);
    for (const Triangle& t : triangles_)
      if (t.unresolved || std::any_of(t.edges.begin(), t.edges.end(), [&](Index e) { return edges_[e].unresolved; }))
        ++result.unresolved;
    return result;
  }

 private:
  using Work = PatchRow<0>;

  /// Calls body(i, work) for each i, in parallel.
  template <class Body>
  void for_each(std::size_t n, const Body& body) const {
    parallel_blocks(
        n, context_,
        [&](std::size_t, std::size_t begin, std::size_t end) {
          Work work;
          for (std::size_t i = begin; i < end; ++i) body(i, work);
        },
        evaluation_block);
  }
  Vec3 point(Index patch, const Vec2& at, Work& work) const {
    return surface_.data().position({patch, at.x(), at.y()}, work);
  }

  Index add_vertex(Index patch, const Vec2& at) {
    parameters_.push_back({patch, at.x(), at.y()});
    positions_.emplace_back(Vec3::Zero());
    return static_cast<Index>(parameters_.size() - 1);
  }
  Index add_edge(Index a, Index b, Index patch, const Vec2& pa, const Vec2& pb) {
    // Inner edges of triangles that have been split often count as short even if they are not, so that there is an end.
    const int least = generation_ / 3;
    edges_.push_back(
        {.a = a, .b = b, .patch = patch, .pa = pa, .pb = pb, .halvings = std::max(least, halvings(pb - pa))});
    return static_cast<Index>(edges_.size() - 1);
  }
  /// How often an edge of the patch has been halved to become as short.
  int halvings(const Vec2& d) const {
    double longest = d.cwiseAbs().maxCoeff();
    if (surface_.data().table.triangular()) longest = std::max(longest, std::abs(d.sum()));
    return std::max(0, 1 - std::ilogb(2 * longest));
  }
  /// Positions of the vertices from `first` on.
  void place_vertices(std::size_t first) {
    for_each(parameters_.size() - first, [&](std::size_t i, Work& work) {
      const SurfaceParameter& parameter = parameters_[first + i];
      if (parameter.patch != no_index) positions_[first + i] = surface_.data().position(parameter, work);
    });
  }

  // The first triangles --------------------------------------------------------------------------------------------

  void add_triangle(Index patch, const std::array<Index, 3>& vertices, const std::array<Index, 3>& edges,
                    const std::array<Vec2, 3>& at) {
    triangles_.push_back({.vertices = vertices, .edges = edges, .patch = patch, .at = at, .generation = generation_});
  }

  /// Cuts the patch of four corners in two.
  void add_square(Index patch, const std::array<Index, 4>& v, const std::array<Index, 4>& e) {
    static const std::array<Vec2, 4> at{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const Index diagonal = add_edge(v[0], v[2], patch, at[0], at[2]);
    add_triangle(patch, {v[0], v[1], v[2]}, {e[0], e[1], diagonal}, {at[0], at[1], at[2]});
    add_triangle(patch, {v[0], v[2], v[3]}, {diagonal, e[2], e[3]}, {at[0], at[2], at[3]});
  }

  void triangulate_control(const FaceList& faces, const Connectivity& topology) {
    const bool triangular = surface_.data().table.triangular();
    static const std::array<Vec2, 3> triangle{{{0, 0}, {1, 0}, {0, 1}}};
    static const std::array<Vec2, 4> square{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const auto whole = [&](std::size_t f) { return faces[f].size() == (triangular ? 3 : 4); };
    // Edges of the control mesh, seen from the first of their faces; those of faces of several patches are halved.
    std::vector<Index> edge(faces.corners.size(), no_index);
    for (Index h = 0; h < faces.corners.size(); ++h) {
      const Index other = topology.opposite[h], f = topology.face(h);
      if (other != no_index && other < h) {
        edge[h] = edge[other];
        continue;
      }
      const Index a = topology.source(h), b = topology.target(h);
      const Index corner = h - faces.offsets[f], patch = surface_.first_patch(f);
      const bool from_other = !whole(f) || other == no_index ? false : !whole(topology.face(other));
      if (whole(f) && !from_other) {
        const Vec2& pa = triangular ? triangle[corner] : square[corner];
        const Vec2& pb = triangular ? triangle[(corner + 1) % 3] : square[(corner + 1) % 4];
        edge[h] = add_edge(a, b, patch, pa, pb);
      } else if (!whole(f)) {
        edge[h] = add_halved_edge(a, b, patch + corner,
                                  surface_.first_patch(f) + (corner + 1) % static_cast<Index>(faces[f].size()));
      } else {
        const Index g = topology.face(other), start = other - faces.offsets[g], first = surface_.first_patch(g);
        edge[h] = add_halved_edge(b, a, first + start, first + (start + 1) % static_cast<Index>(faces[g].size()));
      }
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const auto face = faces[f];
      const Index first = faces.offsets[f], patch = surface_.first_patch(f);
      const auto n = static_cast<Index>(face.size());
      if (triangular) {
        add_triangle(patch, {face[0], face[1], face[2]}, {edge[first], edge[first + 1], edge[first + 2]}, triangle);
      } else if (whole(f)) {
        add_square(patch, {face[0], face[1], face[2], face[3]},
                   {edge[first], edge[first + 1], edge[first + 2], edge[first + 3]});
      } else {
        // One patch per corner, with the middles of its two edges and of the face.
        const Index center = add_vertex(patch, square[2]);
        std::vector<Index> spokes(n);
        for (Index i = 0; i < n; ++i)
          spokes[i] = add_edge(edges_[edge[first + i]].middle, center, patch + i, square[1], square[2]);
        for (Index i = 0; i < n; ++i) {
          const Index before = (i + n - 1) % n;
          const Edge out = edges_[edge[first + i]], in = edges_[edge[first + before]];
          add_square(
              patch + i, {face[i], out.middle, center, in.middle},
              {out.halves[out.a == face[i] ? 0 : 1], spokes[i], spokes[before], in.halves[in.a == face[i] ? 0 : 1]});
        }
      }
      for (Index i = 0; i < n; ++i)
        if (parameters_[face[i]].patch == no_index) {
          const Vec2 at = !whole(f) ? square[0] : triangular ? triangle[i] : square[i];
          parameters_[face[i]] = {whole(f) ? patch : patch + i, at.x(), at.y()};
        }
    }
  }

  /// An edge between two patches of one face, which meet in its middle.
  Index add_halved_edge(Index a, Index b, Index patch_of_a, Index patch_of_b) {
    const Vec2 corner(0, 0), leaving(1, 0), arriving(0, 1);
    const Index e = add_edge(a, b, patch_of_a, corner, leaving);
    const Index middle = add_vertex(patch_of_a, leaving);
    const Index first = add_edge(a, middle, patch_of_a, corner, leaving);
    const Index second = add_edge(middle, b, patch_of_b, arriving, corner);
    edges_[e].middle = middle;
    edges_[e].halves = {first, second};
    edges_[e].split = true;
    return e;
  }

  // Rounds
  // -------------------------------------------------------------------------------------------------------------

  void link_faces() {
    for (Edge& e : edges_) e.faces = {no_index, no_index};
    for (Index t = 0; t < triangles_.size(); ++t)
      for (const Index e : triangles_[t].edges) {
        Edge& edge = edges_[e];
        edge.faces[edge.faces[0] == no_index ? 0 : 1] = t;
        edge.fresh = edge.fresh || triangles_[t].fresh;
      }
  }

  double distance(const Vec3& p, Index t) const {
    const auto& v = triangles_[t].vertices;
    return distance_to_triangle(p, positions_[v[0]], positions_[v[1]], positions_[v[2]]);
  }

  /// How far the surface along an edge is from the triangles there.
  bool deviates(const Edge& e, Work& work) const {
    const int parts = e.halvings == 0 ? 8 : 4;
    for (int i = 1; i < parts; ++i) {
      const double t = static_cast<double>(i) / parts;
      const Vec3 p = point(e.patch, (1 - t) * e.pa + t * e.pb, work);
      const double d = e.faces[1] == no_index ? distance_to_segment(p, positions_[e.a], positions_[e.b])
                                              : std::min(distance(p, e.faces[0]), distance(p, e.faces[1]));
      if (d > limit_) return true;
    }
    return false;
  }

  void mark_edges() {
    std::vector<Index> fresh;
    for (Index e = 0; e < edges_.size(); ++e)
      if (edges_[e].fresh && edges_[e].faces[0] != no_index) {
        edges_[e].fresh = false;
        if (!edges_[e].split) fresh.push_back(e);
      }
    std::vector<char> marked(fresh.size(), 0);
    for_each(fresh.size(), [&](std::size_t i, Work& work) { marked[i] = deviates(edges_[fresh[i]], work) ? 1 : 0; });
    for (std::size_t i = 0; i < fresh.size(); ++i)
      edges_[fresh[i]].unresolved = !mark_if(marked[i] != 0, edges_[fresh[i]]);
  }

  bool splittable(const Edge& e) const { return e.halvings < max_halvings_; }
  /// False if the edge is too short to be split.
  bool mark_if(bool deviates, Edge& e) const {
    if (!deviates) return true;
    e.split = splittable(e);
    return e.split;
  }

  bool deviates_inside(const Triangle& t, Index index, Work& work) const {
    const auto at = [&](double x, double y, double z) {
      const Vec3 p = point(t.patch, x * t.at[0] + y * t.at[1] + z * t.at[2], work);
      if (distance(p, index) <= limit_) return false;
      // In flat regions parameters may run beyond the edge.
      for (const Index e : t.edges)
        for (const Index other : edges_[e].faces)
          if (other != no_index && other != index && distance(p, other) <= limit_) return false;
      return true;
    };
    if (at(1.0 / 3, 1.0 / 3, 1.0 / 3)) return true;
    const bool coarse =
        edges_[t.edges[0]].halvings == 0 || edges_[t.edges[1]].halvings == 0 || edges_[t.edges[2]].halvings == 0;
    const int parts = coarse ? 8 : 4;
    for (int i = 1; i < parts; ++i)
      for (int j = 1; i + j < parts; ++j)
        if (at(static_cast<double>(i) / parts, static_cast<double>(j) / parts,
               static_cast<double>(parts - i - j) / parts))
          return true;
    return false;
  }

  double length(const Edge& e) const { return (positions_[e.b] - positions_[e.a]).squaredNorm(); }
  /// In the parameters, so that halving it makes the triangle smaller.
  Index longest_edge(const Triangle& t) const {
    const bool triangular = surface_.data().table.triangular();
    std::array<double, 3> size;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 d = t.at[(i + 1) % 3] - t.at[i];
      size[i] = d.squaredNorm() + (triangular ? d.x() * d.y() : 0);
    }
    std::size_t best = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (size[i] > size[best] || (size[i] == size[best] && length(edges_[t.edges[i]]) > length(edges_[t.edges[best]])))
        best = i;
    return t.edges[best];
  }
  void mark_faces() {
    const auto is_split = [&](Index e) { return edges_[e].split; };
    std::vector<Index> fresh;
    for (Index t = 0; t < triangles_.size(); ++t) {
      Triangle& triangle = triangles_[t];
      if (triangle.fresh && std::none_of(triangle.edges.begin(), triangle.edges.end(), is_split)) fresh.push_back(t);
      triangle.fresh = false;
    }
    std::vector<char> marked(fresh.size(), 0);
    for_each(fresh.size(), [&](std::size_t i, Work& work) {
      marked[i] = deviates_inside(triangles_[fresh[i]], fresh[i], work) ? 1 : 0;
    });
    for (std::size_t i = 0; i < fresh.size(); ++i)
      triangles_[fresh[i]].unresolved = !mark_if(marked[i] != 0, edges_[longest_edge(triangles_[fresh[i]])]);
  }

  /// Rivara 1984: a triangle that is cut is cut at its longest edge, so that angles in the parameters do not shrink.
  void close_marks() {
    for (bool changed = true; changed;) {
      changed = false;
      for (const Triangle& t : triangles_) {
        if (std::none_of(t.edges.begin(), t.edges.end(), [&](Index e) { return edges_[e].split; })) continue;
        Edge& longest = edges_[longest_edge(t)];
        if (longest.split || !splittable(longest)) continue;
        longest.split = changed = true;
      }
    }
  }

  bool split() {
    generation_ = 0;
    const std::size_t first = positions_.size(), edge_count = edges_.size();
    bool any = false;
    for (std::size_t e = 0; e < edge_count; ++e) {
      if (!edges_[e].split) continue;
      any = any || edges_[e].faces[0] != no_index;
      if (edges_[e].middle == no_index) halve(static_cast<Index>(e));
    }
    if (!any) return false;
    if (4.0 * static_cast<double>(edges_.size()) >= std::numeric_limits<Index>::max())
      throw OptionError("tolerance: the mesh would have more edges than can be indexed");
    place_vertices(first);
    std::vector<Triangle> before;
    before.swap(triangles_);
    triangles_.reserve(before.size() * 2);
    for (const Triangle& t : before) split(t);
    return true;
  }

  void halve(Index e) {
    const Edge edge = edges_[e];
    const Vec2 middle = 0.5 * (edge.pa + edge.pb);
    const Index m = add_vertex(edge.patch, middle);
    const Index first = add_edge(edge.a, m, edge.patch, edge.pa, middle);
    const Index second = add_edge(m, edge.b, edge.patch, middle, edge.pb);
    for (const Index half : {first, second}) edges_[half].halvings = std::max(edges_[half].halvings, edge.halvings + 1);
    edges_[e].middle = m;
    edges_[e].halves = {first, second};
  }

  /// The half of edge e at its end v.
  Index half(Index e, Index v) const { return edges_[e].halves[edges_[e].a == v ? 0 : 1]; }

  void split(const Triangle& t) {
    generation_ = t.generation + 1;
    std::array<bool, 3> cut{};
    std::size_t cuts = 0;
    for (std::size_t i = 0; i < 3; ++i) cuts += (cut[i] = edges_[t.edges[i]].split) ? 1 : 0;
    if (cuts == 0) {
      triangles_.push_back(t);
      return;
    }
    // Turned so that with one cut it is edge 0, with two they are edges 0 and 1.
    std::size_t turn = 0;
    if (cuts < 3)
      while (!cut[turn] || (cuts == 2 && !cut[(turn + 1) % 3])) ++turn;
    const auto of = [&](const auto& values, std::size_t i) { return values[(i + turn) % 3]; };
    const std::array<Index, 3> v{of(t.vertices, 0), of(t.vertices, 1), of(t.vertices, 2)};
    const std::array<Index, 3> e{of(t.edges, 0), of(t.edges, 1), of(t.edges, 2)};
    const std::array<Vec2, 3> p{of(t.at, 0), of(t.at, 1), of(t.at, 2)};
    const std::array<Vec2, 3> q{0.5 * (p[0] + p[1]), 0.5 * (p[1] + p[2]), 0.5 * (p[2] + p[0])};
    const auto middle = [&](std::size_t i) { return edges_[e[i]].middle; };
    const auto inner = [&](Index a, Index b, const Vec2& pa, const Vec2& pb) {
      return add_edge(a, b, t.patch, pa, pb);
    };
    const Index m0 = middle(0);
    if (cuts == 1) {
      const Index n = inner(m0, v[2], q[0], p[2]);
      add_triangle(t.patch, {v[0], m0, v[2]}, {half(e[0], v[0]), n, e[2]}, {p[0], q[0], p[2]});
      add_triangle(t.patch, {m0, v[1], v[2]}, {half(e[0], v[1]), e[1], n}, {q[0], p[1], p[2]});
      return;
    }
    const Index m1 = middle(1), n01 = inner(m0, m1, q[0], q[1]);
    add_triangle(t.patch, {m0, v[1], m1}, {half(e[0], v[1]), half(e[1], v[1]), n01}, {q[0], p[1], q[1]});
    if (cuts == 3) {
      const Index m2 = middle(2), n12 = inner(m1, m2, q[1], q[2]), n20 = inner(m2, m0, q[2], q[0]);
      add_triangle(t.patch, {v[0], m0, m2}, {half(e[0], v[0]), n20, half(e[2], v[0])}, {p[0], q[0], q[2]});
      add_triangle(t.patch, {m1, v[2], m2}, {half(e[1], v[2]), half(e[2], v[2]), n12}, {q[1], p[2], q[2]});
      add_triangle(t.patch, {m0, m1, m2}, {n01, n12, n20}, {q[0], q[1], q[2]});
      return;
    }
    // What is left of two cuts has four corners v0, m0, m1, v2: the shorter diagonal.
    const auto squared = [&](Index a, Index b) { return (positions_[a] - positions_[b]).squaredNorm(); };
    if (squared(v[0], m1) < squared(m0, v[2])) {
      const Index n = inner(v[0], m1, p[0], q[1]);
      add_triangle(t.patch, {v[0], m0, m1}, {half(e[0], v[0]), n01, n}, {p[0], q[0], q[1]});
      add_triangle(t.patch, {v[0], m1, v[2]}, {n, half(e[1], v[2]), e[2]}, {p[0], q[1], p[2]});
    } else {
      const Index n = inner(m0, v[2], q[0], p[2]);
      add_triangle(t.patch, {v[0], m0, v[2]}, {half(e[0], v[0]), n, e[2]}, {p[0], q[0], p[2]});
      add_triangle(t.patch, {m0, m1, v[2]}, {n01, half(e[1], v[2]), n}, {q[0], q[1], p[2]});
    }
  }

  const SurfaceEvaluator& surface_;
  const double limit_;
  const int max_halvings_;
  const RunContext& context_;
  std::vector<SurfaceParameter> parameters_;
  std::vector<Vec3> positions_;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
  int generation_ = 0;  ///< of the triangles and inner edges being made
};

}  // namespace

Tessellation tessellate(const SurfaceEvaluator& surface, const ConnectedMesh& control, double tolerance,
                        int max_halvings, const RunContext& context) {
  return Tessellator(surface, control, tolerance, max_halvings, context).run();
}

}  // namespace gpsrecon::internal
