#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace gpsrecon {
namespace {

void set_faces(const FaceList& faces, Connectivity& c) {
  c.corners = faces.corners;
  c.corners_per_face = faces.all_of_size(3) ? 3 : faces.all_of_size(4) ? 4 : 0;
  if (c.corners_per_face != 0) return;
  c.face_offsets = faces.offsets;
  c.face_of.reserve(c.corners.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    c.face_of.insert(c.face_of.end(), faces[f].size(), static_cast<Index>(f));
}

std::pair<Index, Index> ends(const Connectivity& c, Index h) {
  return std::minmax({c.source(h), c.target(h)});
}

/// Per half-edge the first one between the same vertices. The half-edges are put by their smaller end (a counting
/// sort); among those of one vertex the larger end tells, in a table that need not be cleared.
std::vector<Index> first_between_ends(const Connectivity& c) {
  const std::size_t n = c.half_edge_count();
  std::vector<Index> start(c.vertex_count + 1, 0), by_smaller(n), first(n);
  for (Index h = 0; h < n; ++h) ++start[ends(c, h).first + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Index> cursor(start.begin(), start.end() - 1);
  for (Index h = 0; h < n; ++h) by_smaller[cursor[ends(c, h).first]++] = h;
  struct Met {
    Index with = no_index, at = no_index;
  };
  std::vector<Met> met(c.vertex_count);
  for (Index v = 0; v < c.vertex_count; ++v)
    for (Index k = start[v]; k < start[v + 1]; ++k) {
      const Index h = by_smaller[k];
      Met& other = met[ends(c, h).second];
      if (other.with != v) other = {v, h};
      first[h] = other.at;
    }
  return first;
}

/// Numbers edges in the order of their first half-edges, and pairs the half-edges of those that have two.
void set_edges(Connectivity& c) {
  const std::vector<Index> first = first_between_ends(c);
  const std::size_t n = c.half_edge_count();
  c.opposite.assign(n, no_index);
  c.edge.resize(n);
  c.edge_start.reserve(n / 2 + 1);
  std::vector<Index> halves;
  halves.reserve(n / 2 + 1);
  for (Index h = 0; h < n; ++h) {
    const Index f = first[h];
    if (f == h) {
      c.edge[h] = static_cast<Index>(c.edge_start.size());
      c.edge_start.push_back(h);
      halves.push_back(1);
      continue;
    }
    c.edge[h] = c.edge[f];
    const Index count = ++halves[c.edge[h]];
    if (count == 2 && c.source(f) != c.source(h)) {
      c.opposite[f] = h;
      c.opposite[h] = f;
    } else if (count == 3 && c.opposite[f] != no_index) {
      c.opposite[c.opposite[f]] = no_index;
      c.opposite[f] = no_index;
    }
  }
  const auto note = [&c](Index h, std::size_t& count, Index& first_of_all) {
    if (count++ == 0 || ends(c, h) < ends(c, first_of_all)) first_of_all = h;
  };
  for (std::size_t e = 0; e < halves.size(); ++e) {
    const Index h = c.edge_start[e];
    if (halves[e] > 2)
      note(h, c.nonmanifold_edges, c.first_nonmanifold);
    else if (halves[e] == 2 && c.opposite[h] == no_index)
      note(h, c.inconsistent_edges, c.first_inconsistent);
  }
}

void set_vertices(Connectivity& c) {
  c.vertex_start.assign(c.vertex_count, no_index);
  c.face_count.assign(c.vertex_count, 0);
  for (Index h = 0; h < c.half_edge_count(); ++h) {
    const Index v = c.source(h);
    if (c.vertex_start[v] == no_index || c.opposite[h] == no_index) c.vertex_start[v] = h;
    ++c.face_count[v];
  }
}

}  // namespace

Connectivity build_connectivity(const FaceList& faces, std::size_t vertex_count) {
  for (const Index v : faces.corners)
    if (v >= vertex_count) throw InvariantError("mesh: vertex index " + std::to_string(v) + " is out of range");
  Connectivity c;
  c.vertex_count = vertex_count;
  set_faces(faces, c);
  set_edges(c);
  set_vertices(c);
  return c;
}

Connectivity manifold_connectivity(const FaceList& faces, std::size_t vertex_count, const char* what) {
  Connectivity c = build_connectivity(faces, vertex_count);
  const std::string faults = manifold_faults(c);
  if (!faults.empty()) throw InvariantError(std::string(what) + ": " + faults);
  return c;
}

Connectivity validated_connectivity(const CovMesh& mesh) {
  validate(mesh.vertices);
  validate(mesh.faces, mesh.vertices.size());
  for (std::size_t f = 0; mesh.rules.scheme == Scheme::loop && f < mesh.faces.size(); ++f)
    if (const std::size_t corners = mesh.faces[f].size(); corners != 3)
      throw InvariantError("covariance mesh: face " + std::to_string(f) + " has " + std::to_string(corners) +
                           " corners; Loop's scheme refines triangles, Catmull and Clark's any polygons");
  return manifold_connectivity(mesh.faces, mesh.vertices.size(), "covariance mesh");
}

Connectivity over_vertices(Connectivity c, std::vector<Index> corners, std::size_t vertex_count) {
  c.corners = std::move(corners);
  c.vertex_count = vertex_count;
  set_vertices(c);
  return c;
}

FaceList face_list(const Connectivity& c) {
  FaceList faces;
  faces.corners = c.corners;
  faces.offsets.resize(c.face_total() + 1);
  for (Index f = 0; f < faces.offsets.size(); ++f) faces.offsets[f] = c.face_start(f);
  return faces;
}

VertexEdges vertex_edges(const Connectivity& c) {
  VertexEdges at{std::vector<Index>(c.vertex_count + 1, 0), std::vector<Index>(2 * c.edge_count())};
  const auto for_each_end = [&c](const auto& visit) {
    for (Index e = 0; e < c.edge_count(); ++e) visit(c.source(c.edge_start[e]), e), visit(c.target(c.edge_start[e]), e);
  };
  for_each_end([&](Index v, Index) { ++at.offsets[v + 1]; });
  std::partial_sum(at.offsets.begin(), at.offsets.end(), at.offsets.begin());
  std::vector<Index> cursor(at.offsets.begin(), at.offsets.end() - 1);
  for_each_end([&](Index v, Index e) { at.edges[cursor[v]++] = e; });
  return at;
}

}  // namespace gpsrecon
