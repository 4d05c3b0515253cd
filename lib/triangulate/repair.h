#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/triangulate/front.h>
#include <gpsrecon/triangulate/growing_surface.h>
#include <vector>

namespace gpsrecon {

/// Closes boundary loops of at most options.max_pinhole_edges edges with triangles between vertices that overlap, where
/// possible around a component that is still unused. Returns the number of loops closed.
std::size_t close_pinholes(GrowingSurface& surface, const Mixture& mixture, const OverlapGraph& graph,
                           const std::vector<Vec3>& sheet_normals, const TriangulateOptions& options);

/// Gives every fan of a vertex but the largest a vertex of its own: a copy of the component with its share of the
/// weight, moved a little into its fan, so that welding equal positions does not join them again. Appends to `vertices`
/// and `component_of_vertex`. Returns the number of copies.
std::size_t split_vertices(Mixture& vertices, std::vector<Index>& component_of_vertex, FaceList& faces);

struct Specks {
  std::size_t count = 0;  ///< components of faces removed
  double weight = 0;      ///< of the vertices that no face uses any more
};
/// Removes connected components of faces whose vertices carry less than `min_share` of the weight of the mixture; the
/// heaviest one stays.
Specks drop_specks(const Mixture& vertices, FaceList& faces, double min_share);

/// Turns closed components outward (signed volume), open ones towards the sensor if it is known, else away from their
/// centroid, flat ones up (+z, if upright +y, else +x). Returns the number of components turned over.
std::size_t orient(const Mixture& vertices, FaceList& faces, const std::optional<Vec3>& sensor);

}  // namespace gpsrecon
