// Hole filling: Liepa 2003 (minimal triangulation, refinement, fairing), by CGAL.

#include <gpsrecon/triangulate/hole_patch.h>

#include <gpsrecon/core/editable_mesh.h>

#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace gpsrecon::internal {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Surface = EditableMesh;
using Vertex = Surface::Vertex_index;
using HalfEdge = Surface::Halfedge_index;
using Face = Surface::Face_index;
using Faces = std::vector<Face>;

/// Rings of faces that are cut out around an intersection, at most.
constexpr int most_rings = 3;

Vec3 to_vec(const Surface::Point& p) {
  return {p.x(), p.y(), p.z()};
}

CGAL::Bbox_3 box_of(const Surface& surface, Face f) {
  CGAL::Bbox_3 box;
  for (const Vertex v : CGAL::vertices_around_face(surface.halfedge(f), surface)) box += surface.point(v).bbox();
  return box;
}

void sort_unique(Faces& faces) {
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
}

/// Faces, sorted, and those that share a vertex with one of them.
Faces with_ring(const Surface& surface, const Faces& faces) {
  Faces wider;
  for (const Face f : faces)
    for (const Vertex v : CGAL::vertices_around_face(surface.halfedge(f), surface))
      for (const Face g : CGAL::faces_around_target(surface.halfedge(v), surface))
        if (g != Surface::null_face()) wider.push_back(g);
  sort_unique(wider);
  return wider;
}

/// A connected set of faces to be cut out of the surface.
struct CutOut {
  std::vector<std::vector<HalfEdge>> rims;  ///< half-edges that have no neighbour among the faces, in order
  long holes = 0;                           ///< boundary loops of the surface that go with the faces
  long euler = 0;
  /// Handles that are gone once every rim has a disc instead, if the rest of the surface stays connected.
  long handles() const { return (static_cast<long>(rims.size()) - euler - holes) / 2; }
};

/// `faces`, sorted. Without rims if one passes a vertex twice, or meets the boundary of the surface.
CutOut cut_out(const Surface& surface, const Faces& faces) {
  std::vector<HalfEdge> open, border;
  std::vector<Vertex> vertices;
  for (const Face f : faces)
    for (const HalfEdge h : CGAL::halfedges_around_face(surface.halfedge(f), surface)) {
      vertices.push_back(surface.target(h));
      const HalfEdge across = surface.opposite(h);
      if (surface.is_border(across))
        border.push_back(across);
      else if (!std::binary_search(faces.begin(), faces.end(), surface.face(across)))
        open.push_back(h);
    }
  for (const HalfEdge h : border)
    if (std::any_of(open.begin(), open.end(), [&](HalfEdge rim) { return surface.target(rim) == surface.target(h); }))
      return {};
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const std::size_t edges = (3 * faces.size() + open.size() + border.size()) / 2;
  CutOut result;
  result.euler = static_cast<long>(vertices.size() + faces.size()) - static_cast<long>(edges);
  // A boundary loop that does not meet a rim is one of the faces as a whole.
  for (std::vector<HalfEdge> left = border; !left.empty(); ++result.holes) {
    const HalfEdge start = left.back();
    HalfEdge h = start;
    do {
      std::erase(left, h);
      h = surface.next(h);
    } while (h != start);
  }
  std::vector<char> seen(open.size(), 0);
  for (std::size_t start = 0; start < open.size(); ++start) {
    if (seen[start]) continue;
    std::vector<HalfEdge> rim;
    for (std::size_t at = start; !seen[at];) {
      seen[at] = 1;
      rim.push_back(open[at]);
      std::vector<std::size_t> next;
      for (std::size_t k = 0; k < open.size(); ++k)
        if (surface.source(open[k]) == surface.target(open[at])) next.push_back(k);
      if (next.size() != 1) return {};
      at = next.front();
    }
    result.rims.push_back(std::move(rim));
  }
  return result;
}

/// The rim of a disc of faces away from the boundary of the surface; empty if the faces are no disc.
std::vector<HalfEdge> rim_of_disc(const Surface& surface, const Faces& faces) {
  CutOut disc = cut_out(surface, faces);
  return disc.euler == 1 && disc.rims.size() == 1 ? std::move(disc.rims.front()) : std::vector<HalfEdge>();
}

/// A way over faces, none of them in `barrier` (sorted), leads from one face to the other.
bool connected(const Surface& surface, Face from, Face to, const Faces& barrier) {
  std::vector<char> seen(surface.num_faces(), 0);
  for (const Face f : barrier) seen[static_cast<std::size_t>(f)] = 1;
  Faces queue{from};
  seen[static_cast<std::size_t>(from)] = 1;
  for (std::size_t k = 0; k < queue.size() && queue[k] != to; ++k)
    for (const Face g : CGAL::faces_around_face(surface.halfedge(queue[k]), surface)) {
      if (g == Surface::null_face() || seen[static_cast<std::size_t>(g)]) continue;
      seen[static_cast<std::size_t>(g)] = 1;
      queue.push_back(g);
    }
  return seen[static_cast<std::size_t>(to)] != 0;
}

/// Groups of faces that share vertices.
std::vector<Faces> clusters(const Surface& surface, Faces faces) {
  std::vector<Faces> found;
  while (!faces.empty()) {
    Faces cluster{faces.front()};
    for (std::size_t before = 0; before != cluster.size();) {
      before = cluster.size();
      const Faces wider = with_ring(surface, cluster);
      cluster.clear();
      std::set_intersection(wider.begin(), wider.end(), faces.begin(), faces.end(), std::back_inserter(cluster));
    }
    Faces rest;
    std::set_difference(faces.begin(), faces.end(), cluster.begin(), cluster.end(), std::back_inserter(rest));
    faces = std::move(rest);
    found.push_back(std::move(cluster));
  }
  return found;
}

}  // namespace

struct HolePatcher::Impl {
  Surface surface;
  std::vector<Index> number;  // per vertex of `surface`, whose slots are used again: its number outside
  Index vertices = 0;

  Index number_of(Vertex v) const { return number[static_cast<std::size_t>(v)]; }
  void set_number(Vertex v, Index n) {
    const auto slot = static_cast<std::size_t>(v);
    if (slot >= number.size()) number.resize(slot + 1, no_index);
    number[slot] = n;
  }

  /// Two edges between the same vertices: the patch has one that the surface has, too.
  bool doubles_an_edge(const Faces& faces) const {
    for (const Face f : faces)
      for (const HalfEdge h : CGAL::halfedges_around_face(surface.halfedge(f), surface)) {
        std::size_t count = 0;
        for (const Vertex to : CGAL::vertices_around_target(surface.source(h), surface))
          count += to == surface.target(h) ? 1 : 0;
        if (count != 1) return true;
      }
    return false;
  }

  /// The patch against itself and the faces near it; what intersects elsewhere already is not its fault.
  bool intersects(Faces faces) const {
    CGAL::Bbox_3 box;
    for (const Face f : faces) box += box_of(surface, f);
    Faces near;
    for (const Face f : surface.faces())
      if (CGAL::do_overlap(box_of(surface, f), box)) near.push_back(f);
    std::sort(faces.begin(), faces.end());
    std::vector<std::pair<Face, Face>> pairs;
    pmp::self_intersections(near, surface, std::back_inserter(pairs));
    const auto in_patch = [&](Face f) { return std::binary_search(faces.begin(), faces.end(), f); };
    return std::any_of(pairs.begin(), pairs.end(),
                       [&](const auto& p) { return in_patch(p.first) || in_patch(p.second); });
  }

  /// Fills the hole beside a border half-edge; returns its faces, none if there is no way.
  Faces fill(HalfEdge border, HolePatch& patch) {
    Faces faces;
    std::vector<Vertex> added;
    pmp::triangulate_refine_and_fair_hole(surface, border, std::back_inserter(faces), std::back_inserter(added));
    patch = {};
    patch.first_new = vertices;
    for (const Vertex v : added) {
      set_number(v, patch.first_new + static_cast<Index>(patch.positions.size()));
      patch.positions.push_back(to_vec(surface.point(v)));
    }
    for (const Face f : faces) patch.faces.push_back(corners(f));
    return faces;
  }

  std::array<Index, 3> corners(Face f) const {
    std::array<Index, 3> result{};
    auto corner = result.begin();
    for (const Vertex v : CGAL::vertices_around_face(surface.halfedge(f), surface)) *corner++ = number_of(v);
    return result;
  }

  void remove(const Faces& faces) {
    for (const Face f : faces) CGAL::Euler::remove_face(surface.halfedge(f), surface);
  }

  /// Replaces faces by one patch per rim that intersects nothing and is `wanted`. Otherwise nothing changes.
  bool replace(const Faces& faces, const std::vector<std::vector<HalfEdge>>& rims, const Wanted& wanted,
               const Replaced& replaced) {
    const Surface surface_before = surface;
    const std::vector<Index> number_before = number;
    const Index vertices_before = vertices;
    std::vector<std::pair<Vertex, Vertex>> borders;
    std::vector<std::vector<Index>> numbers;
    for (const std::vector<HalfEdge>& rim : rims) {
      borders.emplace_back(surface.source(rim.front()), surface.target(rim.front()));
      numbers.push_back(sources(rim));
    }
    remove(faces);
    std::vector<HolePatch> patches;
    for (const auto& [from, to] : borders) {
      const Faces filled = fill(surface.halfedge(from, to), patches.emplace_back());
      if (filled.empty() || doubles_an_edge(filled) || !wanted(patches.back()) || intersects(filled)) {
        surface = surface_before;
        number = number_before;
        vertices = vertices_before;
        return false;
      }
      vertices += static_cast<Index>(patches.back().positions.size());
    }
    for (std::size_t k = 0; k < rims.size(); ++k) replaced(numbers[k], patches[k]);
    return true;
  }

  /// Replaces the faces, and up to a few rings around them, if at least so many handles are gone then and the surface
  /// stays as connected as it is.
  bool replace_with_rings(Faces faces, long min_handles, const Wanted& wanted, const Replaced& replaced) {
    for (int ring = 0; ring <= most_rings; ++ring, faces = with_ring(surface, faces)) {
      const CutOut part = cut_out(surface, faces);
      if (part.rims.empty() || part.handles() < min_handles) continue;
      const auto across = [&](const std::vector<HalfEdge>& rim) { return surface.face(surface.opposite(rim.front())); };
      if (std::all_of(part.rims.begin() + 1, part.rims.end(),
                      [&](const std::vector<HalfEdge>& rim) {
                        return connected(surface, across(part.rims.front()), across(rim), faces);
                      }) &&
          replace(faces, part.rims, wanted, replaced))
        return true;
    }
    return false;
  }

  /// The vertices of a loop; empty if one of them or of the edges between them is gone.
  std::vector<Vertex> find(const std::vector<Index>& loop) const {
    std::vector<Vertex> at(loop.size(), Surface::null_vertex());
    for (const Vertex v : surface.vertices()) {
      const auto place = std::find(loop.begin(), loop.end(), number_of(v));
      if (place != loop.end()) at[static_cast<std::size_t>(place - loop.begin())] = v;
    }
    for (std::size_t k = 0; k < at.size(); ++k) {
      const Vertex from = at[k], to = at[(k + 1) % at.size()];
      if (from == Surface::null_vertex() || to == Surface::null_vertex()) return {};
      if (surface.halfedge(from, to) == Surface::null_halfedge()) return {};
    }
    return at;
  }

  Faces faces_around(const std::vector<Vertex>& loop) const {
    Faces band;
    for (const Vertex v : loop)
      for (const Face f : CGAL::faces_around_target(surface.halfedge(v), surface))
        if (f != Surface::null_face()) band.push_back(f);
    sort_unique(band);
    return band;
  }

  /// Numbers of the vertices at which the half-edges start.
  std::vector<Index> sources(const std::vector<HalfEdge>& edges) const {
    std::vector<Index> numbers;
    numbers.reserve(edges.size());
    for (const HalfEdge h : edges) numbers.push_back(number_of(surface.source(h)));
    return numbers;
  }
};

HolePatcher::HolePatcher(const std::vector<Vec3>& positions, const FaceList& faces) : impl_(std::make_unique<Impl>()) {
  impl_->surface = editable_mesh(positions, faces);
  impl_->vertices = static_cast<Index>(positions.size());
  impl_->number.resize(positions.size());
  std::iota(impl_->number.begin(), impl_->number.end(), Index{0});
}
HolePatcher::~HolePatcher() = default;
HolePatcher::HolePatcher(HolePatcher&&) noexcept = default;
HolePatcher& HolePatcher::operator=(HolePatcher&&) noexcept = default;

HolePatcher::Outcome HolePatcher::close(const std::vector<Index>& loop, const Wanted& wanted,
                                        const Replaced& replaced) {
  const std::vector<Vertex> at = impl_->find(loop);
  const HalfEdge border = at.empty() ? Surface::null_halfedge() : impl_->surface.halfedge(at[1], at[0]);
  if (border == Surface::null_halfedge() || !impl_->surface.is_border(border)) return Outcome::gone;
  HolePatch patch;
  const Faces faces = impl_->fill(border, patch);
  Outcome outcome = Outcome::closed;
  if (faces.empty() || impl_->doubles_an_edge(faces))
    outcome = Outcome::no_patch;
  else if (!wanted(patch))
    outcome = Outcome::refused;
  else if (impl_->intersects(faces))
    outcome = Outcome::intersecting;
  if (outcome == Outcome::closed) {
    impl_->vertices += static_cast<Index>(patch.positions.size());
    replaced(loop, patch);
    return outcome;
  }
  impl_->remove(faces);
  // A rim that is in the way of its own patch is crumpled: without the faces along it the hole may close.
  if (outcome != Outcome::refused && impl_->replace_with_rings(impl_->faces_around(at), 0, wanted, replaced))
    return Outcome::closed;
  return outcome;
}

void HolePatcher::untangle(const Replaced& replaced) {
  Surface& surface = impl_->surface;
  std::vector<std::pair<Face, Face>> pairs;
  pmp::self_intersections(surface, std::back_inserter(pairs));
  Faces crossing;
  for (const auto& [f, g] : pairs) crossing.insert(crossing.end(), {f, g});
  sort_unique(crossing);
  Faces gone;  // slots of faces replaced, which other faces may have now
  for (const Faces& cluster : clusters(surface, crossing)) {
    const auto is_gone = [&](Face f) { return std::find(gone.begin(), gone.end(), f) != gone.end(); };
    if (std::any_of(cluster.begin(), cluster.end(), is_gone)) continue;
    Faces disc = cluster;
    for (int ring = 0; ring <= most_rings; ++ring, disc = with_ring(surface, disc)) {
      const std::vector<HalfEdge> edges = rim_of_disc(surface, disc);
      if (edges.empty()) continue;
      if (!impl_->replace(
              disc, {edges}, [](const HolePatch&) { return true; }, replaced))
        continue;
      gone.insert(gone.end(), disc.begin(), disc.end());
      break;
    }
  }
}

bool HolePatcher::cut(const std::vector<Index>& loop, const Wanted& wanted, const Replaced& replaced) {
  const std::vector<Vertex> at = impl_->find(loop);
  return !at.empty() && impl_->replace_with_rings(impl_->faces_around(at), 1, wanted, replaced);
}

FaceList HolePatcher::faces() const {
  return face_list(impl_->surface, [this](Vertex v) { return impl_->number_of(v); });
}

}  // namespace gpsrecon::internal
