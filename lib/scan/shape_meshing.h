#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/scan/profile.h>
#include <array>
#include <vector>

// What the shapes build their meshes with.

namespace gpsrecon::internal {

/// Adds two triangles, or what is left of them where corners coincide.
void add_quad(Mesh& mesh, Index a, Index b, Index c, Index d);

/// Indices of the vertices around an axis at one height; one vertex alone on the axis.
using Ring = std::vector<Index>;

/// Adds the surface that a chain of points (ρ, z) sweeps about `axis` (unit), with `segments` vertices per ring,
/// oriented to the right of the chain. A chain that ends where it starts closes. Returns the rings of its points.
std::vector<Ring> sweep(Mesh& mesh, const std::vector<Vec2>& chain, const Vec3& axis, std::size_t segments);

/// Triangulates the plane region bounded by closed polygons (as indices into `points`), inside by parity, with all
/// points as vertices: a constrained Delaunay triangulation (CGAL). Counter-clockwise. The polygons must not meet.
std::vector<std::array<Index, 3>> triangulate_region(const std::vector<Vec2>& points,
                                                     const std::vector<std::vector<Index>>& polygons);

}  // namespace gpsrecon::internal
