#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/io/io.h>
#include <string>

#include "input_file.h"

// Internal to lib/io: the formats, behind the functions of io.h that pick one of them. Readers throw InputError,
// writers OutputError.

namespace gpsrecon::internal::io {

FileKind probe_ply(const InputFile& file);
PointCloud read_ply_points(const InputFile& file);
Mixture read_ply_mixture(const InputFile& file);
CovMesh read_ply_covmesh(const InputFile& file, bool manifold);
Mesh read_ply_mesh(const InputFile& file);
void write_ply(const PointCloud& cloud, const std::string& path, PlyEncoding encoding);
void write_ply(const Mixture& mixture, const std::string& path, PlyEncoding encoding);
void write_ply(const CovMesh& mesh, const std::string& path, PlyEncoding encoding);
void write_ply(const Mesh& mesh, const std::string& path, PlyEncoding encoding);

/// Rows of numbers separated by blanks, commas or semicolons. "#" and "//" begin a comment. A header line (or a comment
/// just before the first row) that names x, y, z and one name per column names the columns as in a PLY file. Without
/// names: three columns are positions; six are positions and normals, or colours if the last three are integers of
/// 0..255 throughout with one above 1; columns beyond the third are otherwise scalars c3, c4, ... If a line has a
/// semicolon, commas are not separators.
PointCloud read_xyz(const InputFile& file);

Mesh read_off(const InputFile& file);
Mesh read_obj(const InputFile& file);
Mesh read_stl(const InputFile& file);
void write_off(const Mesh& mesh, const std::string& path);
void write_obj(const Mesh& mesh, const std::string& path);
/// Polygons are split into fans of triangles; positions are rounded to float, which is all that STL holds.
void write_stl(const Mesh& mesh, const std::string& path);
/// glTF 2.0, binary: positions, normals, and colours (as the linear ones of that format) of one node, triangles, or
/// points if there are no faces. Quads are split along the shorter diagonal, larger polygons into fans. Positions are
/// `float`; where rounding to float would move a vertex by more than 1e-6 of the diagonal of the bounding box, its
/// centre becomes the translation of the node.
void write_glb(const Mesh& mesh, const std::string& path);

PointCloud read_pcd(const InputFile& file);

}  // namespace gpsrecon::internal::io
