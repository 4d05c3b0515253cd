#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <gpsrecon/triangulate/hole_patch.h>
#include <algorithm>
#include <utility>

namespace gpsrecon {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = Surface::Vertex_index;
using Face = Surface::Face_index;

Vec3 to_vec(const Kernel::Point_3& p) {
  return {p.x(), p.y(), p.z()};
}

}  // namespace

struct HolePatcher::Impl {
  Surface surface;
  std::vector<Index> number;  // per vertex of `surface`, whose slots are used again: its number outside
  Index vertices = 0;

  Index& number_of(Vertex v) {
    const auto slot = static_cast<std::size_t>(v);
    if (slot >= number.size()) number.resize(slot + 1, no_index);
    return number[slot];
  }

  /// Two edges between the same vertices: the patch has one that the surface has, too.
  bool doubles_an_edge(const std::vector<Face>& faces) const {
    for (const Face f : faces)
      for (const auto h : CGAL::halfedges_around_face(surface.halfedge(f), surface)) {
        std::size_t count = 0;
        for (const Vertex to : CGAL::vertices_around_target(surface.source(h), surface))
          count += to == surface.target(h) ? 1 : 0;
        if (count != 1) return true;
      }
    return false;
  }

  /// The patch against itself and the faces near it; what intersects elsewhere already is not its fault.
  bool intersects(const std::vector<Face>& faces) const {
    CGAL::Bbox_3 box;
    for (const Face f : faces)
      for (const Vertex v : CGAL::vertices_around_face(surface.halfedge(f), surface)) box += surface.point(v).bbox();
    std::vector<Face> near;
    for (const Face f : surface.faces()) {
      CGAL::Bbox_3 own;
      for (const Vertex v : CGAL::vertices_around_face(surface.halfedge(f), surface)) own += surface.point(v).bbox();
      if (CGAL::do_overlap(own, box)) near.push_back(f);
    }
    std::vector<Face> sorted = faces;
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::pair<Face, Face>> pairs;
    pmp::self_intersections(near, surface, std::back_inserter(pairs));
    const auto in_patch = [&](Face f) { return std::binary_search(sorted.begin(), sorted.end(), f); };
    return std::any_of(pairs.begin(), pairs.end(), [&](const auto& p) { return in_patch(p.first) || in_patch(p.second); });
  }

  void remove(const std::vector<Face>& faces) {
    for (const Face f : faces) CGAL::Euler::remove_face(surface.halfedge(f), surface);
  }
};

HolePatcher::HolePatcher(const std::vector<Vec3>& positions, const FaceList& faces) : impl_(std::make_unique<Impl>()) {
  Surface& surface = impl_->surface;
  surface.reserve(static_cast<Surface::size_type>(positions.size()),
                  static_cast<Surface::size_type>(3 * faces.size() / 2 + positions.size()),
                  static_cast<Surface::size_type>(faces.size()));
  for (const Vec3& p : positions)
    impl_->number_of(surface.add_vertex({p.x(), p.y(), p.z()})) = impl_->vertices++;
  for (std::size_t f = 0; f < faces.size(); ++f)
    surface.add_face(Vertex(faces[f][0]), Vertex(faces[f][1]), Vertex(faces[f][2]));
}
HolePatcher::~HolePatcher() = default;
HolePatcher::HolePatcher(HolePatcher&&) noexcept = default;
HolePatcher& HolePatcher::operator=(HolePatcher&&) noexcept = default;

HolePatcher::Outcome HolePatcher::close(const std::vector<Index>& loop,
                                        const std::function<bool(const HolePatch&)>& wanted, HolePatch& patch) {
  Surface& surface = impl_->surface;
  const auto border = surface.halfedge(Vertex(loop[1]), Vertex(loop[0]));
  if (border == Surface::null_halfedge() || !surface.is_border(border)) return Outcome::no_patch;
  std::vector<Face> faces;
  std::vector<Vertex> vertices;
  pmp::triangulate_refine_and_fair_hole(surface, border, std::back_inserter(faces), std::back_inserter(vertices));
  if (faces.empty()) return Outcome::no_patch;

  patch = {};
  patch.first_new = impl_->vertices;
  for (const Vertex v : vertices) {
    impl_->number_of(v) = patch.first_new + static_cast<Index>(patch.positions.size());
    patch.positions.push_back(to_vec(surface.point(v)));
  }
  for (const Face f : faces) {
    std::array<Index, 3> corners{};
    auto corner = corners.begin();
    for (const Vertex v : CGAL::vertices_around_face(surface.halfedge(f), surface)) *corner++ = impl_->number_of(v);
    patch.faces.push_back(corners);
  }
  Outcome outcome = Outcome::closed;
  if (impl_->doubles_an_edge(faces))
    outcome = Outcome::no_patch;
  else if (!wanted(patch))
    outcome = Outcome::refused;
  else if (impl_->intersects(faces))
    outcome = Outcome::intersecting;
  if (outcome == Outcome::closed)
    impl_->vertices += static_cast<Index>(vertices.size());
  else
    impl_->remove(faces);
  return outcome;
}

}  // namespace gpsrecon
