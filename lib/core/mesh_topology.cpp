#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <algorithm>
#include <numeric>

namespace gpsrecon {
namespace {

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
  Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Index a, Index b) {
    a = find(a), b = find(b);
    // The smaller index is the root, so that roots appear in order.
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace

HalfEdges half_edges(const FaceList& faces, std::size_t vertex_count) {
  const std::size_t n = faces.corners.size();
  HalfEdges result;
  result.next.resize(n);
  result.face.resize(n);
  result.opposite.assign(n, no_index);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::uint32_t h = faces.offsets[f]; h < faces.offsets[f + 1]; ++h) {
      result.next[h] = h + 1 == faces.offsets[f + 1] ? faces.offsets[f] : h + 1;
      result.face[h] = static_cast<Index>(f);
    }
  const auto from = [&](Index h) { return faces.corners[h]; };
  const auto to = [&](Index h) { return faces.corners[result.next[h]]; };

  // Half-edges bucketed by their smaller vertex (counting sort), then sorted by the larger one within a bucket.
  std::vector<Index> start(vertex_count + 1, 0), sorted(n);
  for (Index h = 0; h < n; ++h) ++start[std::min(from(h), to(h)) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Index> cursor(start.begin(), start.end() - 1);
  for (Index h = 0; h < n; ++h) sorted[cursor[std::min(from(h), to(h))]++] = h;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto begin = sorted.begin() + start[v], end = sorted.begin() + start[v + 1];
    const auto larger = [&](Index h) { return std::max(from(h), to(h)); };
    std::sort(begin, end, [&](Index a, Index b) { return larger(a) != larger(b) ? larger(a) < larger(b) : a < b; });
    for (auto group = begin; group != end;) {
      auto group_end = group;
      while (group_end != end && larger(*group_end) == larger(*group)) ++group_end;
      ++result.edges;
      if (group_end - group > 2) {
        if (result.nonmanifold_edges++ == 0) result.first_nonmanifold = *group;
      } else if (group_end - group == 2) {
        if (from(group[0]) == from(group[1])) {
          if (result.inconsistent_edges++ == 0) result.first_inconsistent = *group;
        } else {
          result.opposite[group[0]] = group[1];
          result.opposite[group[1]] = group[0];
        }
      }
      group = group_end;
    }
  }
  return result;
}

std::vector<std::vector<Index>> boundary_loops(const FaceList& faces, const HalfEdges& he) {
  std::vector<std::vector<Index>> loops;
  std::vector<bool> seen(faces.corners.size(), false);
  for (Index start = 0; start < faces.corners.size(); ++start) {
    if (seen[start] || he.opposite[start] != no_index) continue;
    std::vector<Index> loop;
    for (Index h = start; !seen[h];) {
      seen[h] = true;
      loop.push_back(faces.corners[h]);
      // Turn around the end vertex, inside its fan, to the next half-edge without an opposite.
      for (h = he.next[h]; he.opposite[h] != no_index;) h = he.next[he.opposite[h]];
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

Components face_components(const FaceList& faces, const HalfEdges& he) {
  UnionFind sets(faces.size());
  for (std::size_t h = 0; h < he.opposite.size(); ++h)
    if (he.opposite[h] != no_index) sets.join(he.face[h], he.face[he.opposite[h]]);
  Components components;
  components.of_face.resize(faces.size());
  for (Index f = 0; f < faces.size(); ++f) {
    const Index root = sets.find(f);
    components.of_face[f] = root == f ? static_cast<Index>(components.count++) : components.of_face[root];
  }
  return components;
}

std::vector<Index> vertex_fans(const FaceList& faces, const HalfEdges& he, std::size_t vertex_count) {
  // Corners of one vertex are joined across the edges at that vertex; what remains apart is another fan.
  UnionFind sets(faces.corners.size());
  for (Index h = 0; h < faces.corners.size(); ++h) {
    const Index o = he.opposite[h];
    if (o != no_index) sets.join(h, he.next[o]);  // both corners lie at the start vertex of h
  }
  std::vector<Index> fans(vertex_count, 0);
  for (Index h = 0; h < faces.corners.size(); ++h)
    if (sets.find(h) == h) ++fans[faces.corners[h]];
  return fans;
}

std::string manifold_faults(const FaceList& faces, const HalfEdges& he, std::size_t vertex_count) {
  const std::vector<Index> fans = vertex_fans(faces, he, vertex_count);
  const auto touching = [](Index count) { return count > 1; };
  const auto vertices = std::count_if(fans.begin(), fans.end(), touching);
  if (he.nonmanifold_edges == 0 && he.inconsistent_edges == 0 && vertices == 0) return {};
  std::string text;
  const auto add = [&text](std::size_t count, const std::string& what, const std::string& first) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what + " (first: " + first + ")";
  };
  const auto edge = [&](Index h) {
    return h == no_index ? ""
                         : std::to_string(faces.corners[h]) + "-" + std::to_string(faces.corners[he.next[h]]) +
                               " of face " + std::to_string(he.face[h]);
  };
  add(he.nonmanifold_edges, "edges of more than two faces", edge(he.first_nonmanifold));
  add(static_cast<std::size_t>(vertices), "vertices where faces only touch",
      std::to_string(std::find_if(fans.begin(), fans.end(), touching) - fans.begin()));
  add(he.inconsistent_edges, "edges whose faces face opposite sides", edge(he.first_inconsistent));
  return text;
}

Topology topology(const FaceList& faces, std::size_t vertex_count) {
  for (const Index v : faces.corners)
    if (v >= vertex_count) throw InvariantError("mesh: vertex index " + std::to_string(v) + " is out of range");
  const HalfEdges he = half_edges(faces, vertex_count);
  Topology t;
  t.faces = faces.size();
  t.edges = he.edges;
  t.nonmanifold_edges = he.nonmanifold_edges;
  t.inconsistent_edges = he.inconsistent_edges;
  for (const Index o : he.opposite) t.boundary_edges += o == no_index ? 1 : 0;
  t.components = face_components(faces, he).count;
  t.boundary_loops = boundary_loops(faces, he).size();
  for (const Index fans : vertex_fans(faces, he, vertex_count)) {
    t.vertices += fans > 0 ? 1 : 0;
    t.unused_vertices += fans == 0 ? 1 : 0;
    t.nonmanifold_vertices += fans > 1 ? 1 : 0;
  }
  t.euler = static_cast<long>(t.vertices) - static_cast<long>(t.edges) + static_cast<long>(t.faces);
  return t;
}

}  // namespace gpsrecon
