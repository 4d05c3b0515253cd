#include <gpsrecon/triangulate/holes.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/triangulate/handles.h>
#include <gpsrecon/triangulate/hole_patch.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace gpsrecon::internal {
namespace {

/// Weight of a vertex that stands for no point: positive, as weights have to be, and below what any sum shows.
constexpr double no_points_weight = 1e-6;

struct Loop {
  std::vector<Index> vertices;
  double length = 0;
  bool rim = false;
};

/// The loops of a mesh, shortest first. A loop has the surface on its left, so seen from the side of the normals it
/// runs clockwise around a gap and counter-clockwise around a sheet.
std::vector<Loop> find_loops(const CovMesh& mesh, const Connectivity& he) {
  const std::vector<Vec3>& at = mesh.vertices.means;
  std::vector<Vec3> outward(at.size(), Vec3::Zero());  // per start of a boundary half-edge: the normal of its face
  for (Index h = 0; h < he.half_edge_count(); ++h) {
    if (he.opposite[h] != no_index) continue;
    outward[he.source(h)] = unit_normal(at, mesh.faces[he.face(h)]);
  }
  std::vector<Loop> loops;
  for (std::vector<Index>& vertices : boundary_loops(he)) {
    Loop loop{std::move(vertices)};
    const Vec3& origin = at[loop.vertices.front()];
    Vec3 area = Vec3::Zero(), normal = Vec3::Zero();
    for (std::size_t k = 0; k < loop.vertices.size(); ++k) {
      const Vec3 &from = at[loop.vertices[k]], &to = at[loop.vertices[(k + 1) % loop.vertices.size()]];
      const double length = (to - from).norm();
      loop.length += length;
      area += (from - origin).cross(to - from);
      normal += length * outward[loop.vertices[k]];
    }
    loop.rim = area.dot(normal) > 0;
    loops.push_back(std::move(loop));
  }
  std::stable_sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) { return a.length < b.length; });
  return loops;
}

/// Tells whether Gaussians reach everywhere into a patch. A Gaussian reaches, in each direction, as many standard
/// deviations as two equal ones reach towards each other whose Bhattacharyya coefficient, exp(-d²/8σ²), is the smallest
/// that allows an edge: d/2 = sqrt(-2 ln BCmin) σ, 3.03 σ for 0.01. So a gap is covered just if the front could have
/// crossed it, had the Gaussians around it faced each other; one with a left-over Gaussian in it may be twice as wide.
class Support {
 public:
  Support(const Mixture& mixture, double min_overlap)
      : mixture_(mixture), index_(mixture.means), reach2_(-2 * std::log(min_overlap)) {}

  bool covers(const HolePatch& patch, const std::vector<Vec3>& positions) {
    const auto position = [&](Index v) {
      return v < patch.first_new ? positions[v] : patch.positions[v - patch.first_new];
    };
    return std::all_of(patch.positions.begin(), patch.positions.end(), [&](const Vec3& p) { return reaches(p); }) &&
           std::all_of(patch.faces.begin(), patch.faces.end(),
                       [&](const auto& t) { return reaches((position(t[0]) + position(t[1]) + position(t[2])) / 3); });
  }

 private:
  /// The variance in the direction of the point, not the Mahalanobis distance: a patch that bulges a little out of the
  /// plane of a thin Gaussian is still beside it.
  bool reaches(const Vec3& point) {
    constexpr std::size_t nearest = 16;
    index_.nearest(point, nearest, found_);
    return std::any_of(found_.begin(), found_.end(), [&](const Neighbor& n) {
      const Vec3 d = point - mixture_.means[n.index];
      const double d2 = d.squaredNorm();
      return d2 * d2 <= reach2_ * mixture_.covariances[n.index].quadratic_form(d);
    });
  }

  const Mixture& mixture_;
  Neighbors index_;
  double reach2_;
  std::vector<Neighbor> found_;
};

/// Mean length of the edges at each vertex (edges between two faces count twice).
class EdgeLengths {
 public:
  /// Of a face whose corners from `first` on count.
  void add(std::span<const Index> face, const std::vector<Vec3>& positions, Index first = 0) {
    sum_.resize(positions.size(), 0.0);
    count_.resize(positions.size(), 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = face[k], b = face[(k + 1) % 3];
      const double length = (positions[a] - positions[b]).norm();
      for (const Index v : {a, b})
        if (v >= first) sum_[v] += length, ++count_[v];
    }
  }
  double operator[](Index v) const { return sum_[v] / static_cast<double>(count_[v]); }

 private:
  std::vector<double> sum_;
  std::vector<std::size_t> count_;
};

/// What a Gaussian of the rim passes on, as logarithms.
struct RimShape {
  double spread;  ///< in-plane standard deviation over the mean length of the edges at the vertex
  double thickness;
};

/// Gives the new vertices of a patch their Gaussians.
void append_vertices(Mixture& vertices, std::vector<Index>& component_of_vertex, const HolePatch& patch,
                     const std::vector<Index>& rim, EdgeLengths& edges) {
  std::vector<RimShape> shapes;
  shapes.reserve(rim.size());
  for (const Index v : rim) {
    const Vec3 variance = eigen_decomposition(vertices.covariances[v]).values;
    shapes.push_back({0.25 * std::log(variance[1] * variance[2]) - std::log(edges[v]), 0.5 * std::log(variance[0])});
  }
  // Averages over the rim by inverse squared distance; what else a vertex has it takes from the nearest of the rim.
  std::vector<Index> source(vertices.size());
  for (Index v = 0; v < source.size(); ++v) source[v] = v;
  std::vector<RimShape> inherited;
  inherited.reserve(patch.positions.size());
  for (const Vec3& p : patch.positions) {
    RimShape sum{0, 0};
    double weights = 0, nearest2 = std::numeric_limits<double>::infinity();
    Index nearest = rim.front();
    for (std::size_t k = 0; k < rim.size(); ++k) {
      const double d2 = (vertices.means[rim[k]] - p).squaredNorm();
      if (d2 < nearest2) nearest2 = d2, nearest = rim[k];
      const double weight = 1 / std::max(d2, std::numeric_limits<double>::min());
      sum.spread += weight * shapes[k].spread;
      sum.thickness += weight * shapes[k].thickness;
      weights += weight;
    }
    inherited.push_back({sum.spread / weights, sum.thickness / weights});
    source.push_back(nearest);
  }
  vertices = select(vertices, source);
  std::copy(patch.positions.begin(), patch.positions.end(), vertices.means.begin() + patch.first_new);
  component_of_vertex.resize(vertices.size(), no_index);

  std::vector<Vec3> normals(patch.positions.size(), Vec3::Zero());
  for (const auto& t : patch.faces) {
    edges.add(t, vertices.means, patch.first_new);
    const Vec3 normal = area_vector(vertices.means, t);
    for (const Index v : t)
      if (v >= patch.first_new) normals[v - patch.first_new] += normal;
  }
  for (std::size_t k = 0; k < patch.positions.size(); ++k) {
    const Index v = patch.first_new + static_cast<Index>(k);
    const Vec3 normal = normals[k].isZero(0) ? Vec3::UnitZ() : Vec3(normals[k].normalized());
    const double spread = std::exp(inherited[k].spread) * edges[v];
    const double thickness = std::min(std::exp(inherited[k].thickness), spread);
    vertices.covariances[v] =
        Sym3::identity(spread * spread) + (thickness * thickness - spread * spread) * Sym3::outer(normal);
    vertices.weights[v] = no_points_weight;
    if (!vertices.normals.empty()) vertices.normals[v] = normal;
  }
}

}  // namespace

Mending mend(CovMesh& mesh, const Connectivity& connectivity, std::vector<Index>& component_of_vertex,
             const Mixture& mixture, const TriangulateOptions& options, const RunContext& context) {
  Mending result;
  result.reason.assign(mesh.vertices.size(), LoopReason::kept);
  const std::vector<Loop> loops = find_loops(mesh, connectivity);
  const double longest = options.holes.longest.resolve({.diagonal = bounding_box_diagonal(mesh.vertices.means),
                                                        .spacing = mixture.spacing,
                                                        .scene_to_local = 1 / mixture.frame.scale()},
                                                       "holes");
  EdgeLengths edges;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) edges.add(mesh.faces[f], mesh.vertices.means);
  const auto append = [&](const std::vector<Index>& rim, const HolePatch& patch) {
    append_vertices(mesh.vertices, component_of_vertex, patch, rim, edges);
  };
  HolePatcher patcher(mesh.vertices.means, mesh.faces);
  patcher.untangle([&](const std::vector<Index>& rim, const HolePatch& patch) {
    append(rim, patch);
    ++result.untangled;
  });
  std::optional<Support> support;  // made for the first patch that needs it
  const auto supported = [&](const HolePatch& patch) {
    if (!support) support.emplace(mixture, options.min_overlap);
    return support->covers(patch, mesh.vertices.means);
  };
  // Short loops first. Removing one handle may make room to remove the next.
  for (std::size_t before = result.handles + 1; before != result.handles;) {
    before = result.handles;
    for (const std::vector<Index>& loop : handle_loops(mesh.vertices.means, patcher.faces(),
                                                       static_cast<std::size_t>(options.max_handle_edges), context))
      result.handles += patcher.cut(loop, supported, append) ? 1 : 0;
  }

  std::vector<Index> filling;  // vertices made for that
  const auto fill = [&](const Loop& loop) {
    const bool asked =
        options.holes.policy == HolePolicy::all || (options.holes.policy == HolePolicy::fill && loop.length <= longest);
    if (loop.rim && !asked) return std::optional(LoopReason::rim);
    if (options.holes.policy == HolePolicy::keep) return std::optional(LoopReason::kept);
    const auto vertices_before = static_cast<Index>(mesh.vertices.size());
    switch (patcher.close(
        loop.vertices, [&](const HolePatch& p) { return asked || supported(p); }, append)) {
      case HolePatcher::Outcome::closed:
        break;
      case HolePatcher::Outcome::gone:
        return std::optional<LoopReason>();
      case HolePatcher::Outcome::no_patch:
        return std::optional(LoopReason::no_patch);
      case HolePatcher::Outcome::intersecting:
        return std::optional(LoopReason::would_intersect);
      case HolePatcher::Outcome::refused:
        return std::optional(options.holes.policy == HolePolicy::fill ? LoopReason::too_long : LoopReason::no_points);
    }
    ++result.filled;
    result.rims += loop.rim ? 1 : 0;
    for (Index v = vertices_before; v < mesh.vertices.size(); ++v) filling.push_back(v);
    return std::optional<LoopReason>();
  };
  for (const Loop& loop : loops)
    if (const auto reason = fill(loop))
      for (const Index v : loop.vertices) result.reason[v] = *reason;
  mesh.faces = patcher.faces();
  // A patch may have gone again to make room for another.
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const Index v : mesh.faces.corners) used[v] = 1;
  for (const Index v : filling) result.new_vertices += used[v] != 0 ? 1 : 0;
  result.reason.resize(mesh.vertices.size(), LoopReason::kept);
  return result;
}

}  // namespace gpsrecon::internal
