#include <gpsrecon/core/mesh_topology.h>
#include <algorithm>

namespace gpsrecon {

std::vector<std::vector<Index>> boundary_loops(const Connectivity& c) {
  std::vector<std::vector<Index>> loops;
  std::vector<char> seen(c.half_edge_count(), 0);
  for (Index start = 0; start < c.half_edge_count(); ++start) {
    if (seen[start] || c.opposite[start] != no_index) continue;
    std::vector<Index> loop;
    for (Index h = start; !seen[h];) {
      seen[h] = 1;
      loop.push_back(c.source(h));
      // Turn around the end vertex, inside its fan, to the next half-edge without an opposite.
      for (h = c.next(h); c.opposite[h] != no_index;) h = c.next(c.opposite[h]);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

Components face_components(const Connectivity& c) {
  Components components;
  components.of_face.assign(c.face_total(), no_index);
  std::vector<Index> reached;
  for (Index first = 0; first < components.of_face.size(); ++first) {
    if (components.of_face[first] != no_index) continue;
    const auto label = static_cast<Index>(components.count++);
    const auto reach = [&](Index f) {
      if (components.of_face[f] != no_index) return;
      components.of_face[f] = label;
      reached.push_back(f);
    };
    reach(first);
    while (!reached.empty()) {
      const Index f = reached.back();
      reached.pop_back();
      for (Index h = c.face_start(f); h < c.face_start(f + 1); ++h)
        if (c.opposite[h] != no_index) reach(c.face(c.opposite[h]));
    }
  }
  return components;
}

std::vector<Index> vertex_fans(const Connectivity& c) {
  std::vector<Index> fans(c.vertex_count, 0);
  std::vector<char> seen(c.half_edge_count(), 0);
  const auto count_fan = [&](Index h) {
    ++fans[c.source(h)];
    c.for_each_in_fan(h, [&](Index g) { seen[g] = 1; });
  };
  for (Index h = 0; h < seen.size(); ++h)
    if (c.opposite[h] == no_index) count_fan(h);
  for (Index h = 0; h < seen.size(); ++h)
    if (!seen[h]) count_fan(h);
  return fans;
}

std::string manifold_faults(const Connectivity& c) {
  const std::vector<Index> fans = vertex_fans(c);
  const auto touching = [](Index count) { return count > 1; };
  const auto vertices = std::count_if(fans.begin(), fans.end(), touching);
  if (c.nonmanifold_edges == 0 && c.inconsistent_edges == 0 && vertices == 0) return {};
  std::string text;
  const auto add = [&text](std::size_t count, const std::string& what, const std::string& first) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what + " (first: " + first + ")";
  };
  const auto edge = [&](Index h) {
    return h == no_index ? ""
                         : std::to_string(c.source(h)) + "-" + std::to_string(c.target(h)) + " of face " +
                               std::to_string(c.face(h));
  };
  add(c.nonmanifold_edges, "edges of more than two faces", edge(c.first_nonmanifold));
  add(static_cast<std::size_t>(vertices), "vertices where faces only touch",
      std::to_string(std::find_if(fans.begin(), fans.end(), touching) - fans.begin()));
  add(c.inconsistent_edges, "edges whose faces face opposite sides", edge(c.first_inconsistent));
  return text;
}

Topology topology(const Connectivity& c) {
  Topology t;
  t.faces = c.face_total();
  t.edges = c.edge_count();
  t.nonmanifold_edges = c.nonmanifold_edges;
  t.inconsistent_edges = c.inconsistent_edges;
  t.boundary_edges = static_cast<std::size_t>(std::count(c.opposite.begin(), c.opposite.end(), no_index));
  t.components = face_components(c).count;
  t.boundary_loops = boundary_loops(c).size();
  for (const Index fans : vertex_fans(c)) {
    t.vertices += fans > 0 ? 1 : 0;
    t.unused_vertices += fans == 0 ? 1 : 0;
    t.nonmanifold_vertices += fans > 1 ? 1 : 0;
  }
  t.euler = static_cast<long>(t.vertices) - static_cast<long>(t.edges) + static_cast<long>(t.faces);
  return t;
}

Topology topology(const FaceList& faces, std::size_t vertex_count) {
  return topology(build_connectivity(faces, vertex_count));
}

}  // namespace gpsrecon
