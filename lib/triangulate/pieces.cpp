#include <gpsrecon/triangulate/pieces.h>

#include <gpsrecon/core/mesh_topology.h>
#include <algorithm>

namespace gpsrecon::internal {

std::size_t split_vertices(Mixture& vertices, std::vector<Index>& component_of_vertex, FaceList& faces,
                           Connectivity& connectivity) {
  const Connectivity& he = connectivity;
  const std::vector<Index> fan_count = vertex_fans(he);
  std::size_t copies = 0;
  // Per vertex with several fans: the corners of each fan.
  std::vector<std::vector<Index>> corners_at(vertices.size());
  for (Index h = 0; h < faces.corners.size(); ++h)
    if (fan_count[faces.corners[h]] > 1) corners_at[faces.corners[h]].push_back(h);
  const std::size_t original = vertices.size();
  for (Index v = 0; v < original; ++v) {
    if (corners_at[v].empty()) continue;
    std::vector<std::vector<Index>> fans;
    std::vector<Index> open = corners_at[v];
    while (!open.empty()) {
      // Grow the fan of one corner in both directions.
      std::vector<Index> fan{open.front()};
      for (std::size_t k = 0; k < fan.size(); ++k) {
        const auto visit = [&](Index h) {
          if (std::find(fan.begin(), fan.end(), h) == fan.end()) fan.push_back(h);
        };
        const Index out = fan[k];
        const Index in = he.previous(out);
        if (he.opposite[out] != no_index) visit(he.next(he.opposite[out]));
        if (he.opposite[in] != no_index) visit(he.opposite[in]);
      }
      std::erase_if(open, [&](Index h) { return std::find(fan.begin(), fan.end(), h) != fan.end(); });
      fans.push_back(std::move(fan));
    }
    std::stable_sort(fans.begin(), fans.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
    const double weight = vertices.weights[v] / static_cast<double>(fans.size());
    const Vec3 mean = vertices.means[v];
    for (std::size_t f = 0; f < fans.size(); ++f) {
      Index copy = v;
      if (f > 0) {
        copy = append_copy(vertices, v);
        component_of_vertex.push_back(component_of_vertex[v]);
        ++copies;
      }
      vertices.weights[copy] = weight;
      // A tenth of the way to the centroid of the fan.
      Vec3 centroid = Vec3::Zero();
      for (const Index h : fans[f])
        centroid += 0.5 * (vertices.means[faces.corners[he.next(h)]] + vertices.means[faces.corners[he.previous(h)]]);
      centroid /= static_cast<double>(fans[f].size());
      vertices.means[copy] = mean + 0.1 * (centroid - mean);
      for (const Index h : fans[f]) faces.corners[h] = copy;
    }
  }
  if (copies > 0) connectivity = over_vertices(std::move(connectivity), faces.corners, vertices.size());
  return copies;
}

namespace {

/// How much heavier a bubble may be than another small component.
constexpr double bubble_factor = 10;

/// Per component: it is closed and each of its vertices overlaps a heavier one. `members` are pairs of component and
/// vertex.
std::vector<char> bubbles(const OverlapGraph& graph, const Connectivity& he, const Components& components,
                          const std::vector<std::pair<Index, Index>>& members, const std::vector<double>& weight) {
  if (graph.links.empty()) return std::vector<char>(components.count, 0);
  std::vector<char> bubble(components.count, 1);
  std::vector<Index> component_at(graph.offset.size() - 1, no_index);
  for (const auto& [component, v] : members)
    if (component_at[v] == no_index || weight[component] > weight[component_at[v]]) component_at[v] = component;
  for (const auto& [component, v] : members) {
    const auto links = graph[v];
    const bool covered = std::any_of(links.begin(), links.end(), [&, c = component](const OverlapGraph::Link& link) {
      const Index other = component_at[link.to];
      return other != no_index && weight[other] > weight[c];
    });
    if (!covered) bubble[component] = 0;
  }
  for (Index h = 0; h < he.half_edge_count(); ++h)
    if (he.opposite[h] == no_index) bubble[components.of_face[he.face(h)]] = 0;
  return bubble;
}

}  // namespace

DroppedComponents drop_small_components(const Mixture& vertices, const OverlapGraph& graph, FaceList& faces,
                                        Connectivity& connectivity, double min_share) {
  const Connectivity& he = connectivity;
  const Components components = face_components(he);
  // A vertex where components touch counts for each of them, once.
  std::vector<std::pair<Index, Index>> members;  // component, vertex
  members.reserve(faces.corners.size());
  for (Index h = 0; h < he.half_edge_count(); ++h)
    members.emplace_back(components.of_face[he.face(h)], faces.corners[h]);
  std::sort(members.begin(), members.end());
  members.erase(std::unique(members.begin(), members.end()), members.end());
  std::vector<double> weight(components.count, 0);
  for (const auto& [component, v] : members) weight[component] += vertices.weights[v];
  double total = 0;
  for (const double w : vertices.weights) total += w;
  // Never everything: the heaviest component stays whatever its share.
  const auto heaviest = static_cast<std::size_t>(std::max_element(weight.begin(), weight.end()) - weight.begin());
  DroppedComponents dropped;
  const std::vector<char> bubble = bubbles(graph, he, components, members, weight);
  std::vector<char> drop(components.count, 0);
  for (std::size_t c = 0; c < components.count; ++c) {
    if (c == heaviest || weight[c] >= (bubble[c] ? bubble_factor : 1) * min_share * total) continue;
    drop[c] = 1;
    ++dropped.count;
  }
  if (dropped.count == 0) return dropped;
  FaceList kept;
  kept.reserve(faces.size(), faces.corners.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (!drop[components.of_face[f]]) kept.add(faces[f]);
  // What is lost is the weight of the vertices that no face uses any more.
  std::vector<char> counted(vertices.size(), 0);
  for (const Index v : kept.corners) counted[v] = 1;
  for (const auto& [component, v] : members) {
    if (counted[v]) continue;
    counted[v] = 1;
    dropped.weight += vertices.weights[v];
  }
  faces = std::move(kept);
  connectivity = build_connectivity(faces, vertices.size());
  return dropped;
}

}  // namespace gpsrecon::internal
