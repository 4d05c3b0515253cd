#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <gpsrecon/triangulate/hole_patch.h>
#include <algorithm>
#include <iterator>
#include <utility>

namespace gpsrecon {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = Surface::Vertex_index;
using HalfEdge = Surface::Halfedge_index;
using Face = Surface::Face_index;
using Faces = std::vector<Face>;

/// Rings of faces that are cut out around an intersection, at most.
constexpr int most_rings = 3;

Vec3 to_vec(const Kernel::Point_3& p) {
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

/// The half-edges of a disc of faces that have no neighbour in it, in order around it; empty if the faces are no disc
/// or touch the boundary of the surface.
std::vector<HalfEdge> rim_of_disc(const Surface& surface, const Faces& faces) {
  std::vector<HalfEdge> open;
  std::vector<Vertex> vertices;
  for (const Face f : faces)
    for (const HalfEdge h : CGAL::halfedges_around_face(surface.halfedge(f), surface)) {
      vertices.push_back(surface.target(h));
      const HalfEdge across = surface.opposite(h);
      if (surface.is_border(across)) return {};
      if (!std::binary_search(faces.begin(), faces.end(), surface.face(across))) open.push_back(h);
    }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const std::size_t edges = (3 * faces.size() + open.size()) / 2;
  if (vertices.size() + faces.size() != edges + 1) return {};
  // One loop, through each vertex once.
  std::vector<HalfEdge> rim{open.front()};
  while (rim.size() <= open.size()) {
    const Vertex at = surface.target(rim.back());
    std::vector<HalfEdge> next;
    std::copy_if(open.begin(), open.end(), std::back_inserter(next),
                 [&](HalfEdge h) { return surface.source(h) == at; });
    if (next.size() != 1) return {};
    if (next.front() == rim.front()) break;
    rim.push_back(next.front());
  }
  return rim.size() == open.size() ? rim : std::vector<HalfEdge>();
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

  /// Replaces a disc of faces by a patch that intersects nothing. Otherwise nothing changes.
  bool replace(const Faces& disc, const std::vector<HalfEdge>& rim, HolePatch& patch) {
    const Surface surface_before = surface;
    const std::vector<Index> number_before = number;
    const Vertex from = surface.source(rim.front()), to = surface.target(rim.front());
    remove(disc);
    const Faces faces = fill(surface.halfedge(from, to), patch);
    if (!faces.empty() && !doubles_an_edge(faces) && !intersects(faces)) {
      vertices += static_cast<Index>(patch.positions.size());
      return true;
    }
    surface = surface_before;
    number = number_before;
    return false;
  }
};

HolePatcher::HolePatcher(const std::vector<Vec3>& positions, const FaceList& faces) : impl_(std::make_unique<Impl>()) {
  Surface& surface = impl_->surface;
  surface.reserve(static_cast<Surface::size_type>(positions.size()),
                  static_cast<Surface::size_type>(3 * faces.size() / 2 + positions.size()),
                  static_cast<Surface::size_type>(faces.size()));
  for (const Vec3& p : positions) impl_->set_number(surface.add_vertex({p.x(), p.y(), p.z()}), impl_->vertices++);
  for (std::size_t f = 0; f < faces.size(); ++f)
    surface.add_face(Vertex(faces[f][0]), Vertex(faces[f][1]), Vertex(faces[f][2]));
}
HolePatcher::~HolePatcher() = default;
HolePatcher::HolePatcher(HolePatcher&&) noexcept = default;
HolePatcher& HolePatcher::operator=(HolePatcher&&) noexcept = default;

HolePatcher::Outcome HolePatcher::close(const std::vector<Index>& loop,
                                        const std::function<bool(const HolePatch&)>& wanted, HolePatch& patch) {
  // Vertices on a boundary were there from the beginning, and still have their slots.
  const HalfEdge border = impl_->surface.halfedge(Vertex(loop[1]), Vertex(loop[0]));
  if (border == Surface::null_halfedge() || !impl_->surface.is_border(border)) return Outcome::no_patch;
  const Faces faces = impl_->fill(border, patch);
  if (faces.empty()) return Outcome::no_patch;
  Outcome outcome = Outcome::closed;
  if (impl_->doubles_an_edge(faces))
    outcome = Outcome::no_patch;
  else if (!wanted(patch))
    outcome = Outcome::refused;
  else if (impl_->intersects(faces))
    outcome = Outcome::intersecting;
  if (outcome == Outcome::closed)
    impl_->vertices += static_cast<Index>(patch.positions.size());
  else
    impl_->remove(faces);
  return outcome;
}

void HolePatcher::untangle(const std::function<void(const std::vector<Index>& rim, const HolePatch&)>& replaced) {
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
      std::vector<Index> rim;
      for (const HalfEdge h : edges) rim.push_back(impl_->number_of(surface.source(h)));
      HolePatch patch;
      if (!impl_->replace(disc, edges, patch)) continue;
      gone.insert(gone.end(), disc.begin(), disc.end());
      replaced(rim, patch);
      break;
    }
  }
}

FaceList HolePatcher::faces() const {
  FaceList faces;
  faces.reserve(impl_->surface.number_of_faces(), 3 * impl_->surface.number_of_faces());
  for (const Face f : impl_->surface.faces()) faces.add(impl_->corners(f));
  return faces;
}

}  // namespace gpsrecon
