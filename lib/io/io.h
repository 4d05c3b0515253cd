#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/point_cloud.h>
#include <cstdint>
#include <string>

// Reading and writing by file name; the format follows from the extension (and for PLY from the header). Paths are
// given as they are to the operating system; "-" is standard input or output, always PLY. Every reader throws
// InputError, naming the file, the position in it and what was expected; every writer throws OutputError and leaves
// either the complete file or the file that was there before (a temporary file is written and renamed).
//
// Coordinates in files are world coordinates. Points and meshes are returned in the identity frame. Mixtures and
// covariance meshes that carry a frame in their header are returned in that frame: covariances, weights, sigma0 and
// spacing come back bit for bit, means to the rounding of world coordinates (bit for bit where these are exact), see
// as_stored().
//
// Time and memory are linear in the size of the file. Nothing is allocated by a count that a file merely claims.

namespace gpsrecon {

enum class FileKind { points, mixture, covmesh, mesh };

/// What a file holds, told from the extension and header alone (a PLY with covariance columns is a mixture, with faces
/// too a covariance mesh, with faces only a mesh). Throws InputError.
FileKind probe_file(const std::string& path);

/// Points of a PLY (any dialect), XYZ/TXT/ASC/CSV or PCD file; the vertices of a mesh file. Rows that are not finite
/// are kept: they are for the caller to count and drop. Columns nx ny nz are normals, red green blue colours, sx sy sz
/// sensor positions, others scalars. Text without column names: three columns are positions, six are positions and
/// normals (or colours, if the last three are integers of 0..255 throughout with one above 1), else the fourth and
/// further ones are scalars c3, c4, ...
PointCloud read_points(const std::string& path);

/// PLY with columns x y z covxx covxy covxz covyy covyz covzz, optionally weight (else 1) and nvx nvy nvz, of an
/// element `vertex` or `component`. The result is valid; InputError also if it would not be.
Mixture read_mixture(const std::string& path);
/// The rules of the surface are those of the file, or, where it tells none, rules_for() its faces.
/// With manifold = false nothing is promised of the faces: what repair_topology is to mend.
CovMesh read_covmesh(const std::string& path, bool manifold = true);

/// A polygon soup of a PLY, OFF, OBJ or STL file (equal STL corners are merged, vertices without faces are kept). Faces
/// have at least three corners, all of them valid; nothing else is promised.
Mesh read_mesh(const std::string& path);

/// How numbers are stored in PLY files.
enum class PlyEncoding { binary, ascii };

/// Points are stored without loss (`float` where that is exact, else `double`), mixtures and covariance meshes as
/// `double`.
void write_points(const PointCloud& cloud, const std::string& path, PlyEncoding encoding = PlyEncoding::binary);
void write_mixture(const Mixture& mixture, const std::string& path, PlyEncoding encoding = PlyEncoding::binary);
void write_covmesh(const CovMesh& mesh, const std::string& path, PlyEncoding encoding = PlyEncoding::binary);

/// PLY, OFF, OBJ, STL or glTF (.glb) by extension. Positions in PLY are `float`, or `double` where rounding to float
/// would move a vertex by more than 1e-6 of the bounding-box diagonal; labels are `int`, other scalars `float` or
/// `double` likewise. The others hold positions and faces, OFF, OBJ and glTF colours too, OBJ and glTF normals; other
/// attributes are left out. STL and glTF have triangles only, into which polygons are split.
void write_mesh(const Mesh& mesh, const std::string& path, PlyEncoding encoding = PlyEncoding::binary);

/// Throws OutputError unless a file can be created at `path` (its folder exists and is writable, it is not a directory)
/// and its extension is one that `write_mesh` knows if `mesh_format` is set. Leaves nothing behind.
void check_writable(const std::string& path, bool mesh_format = false);

}  // namespace gpsrecon
