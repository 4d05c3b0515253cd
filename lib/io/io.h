#pragma once

#include <cstdint>
#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/point_cloud.h>
#include <string>

// Reading and writing by file name; the format follows from the extension (and for PLY from the header). Paths are
// given as they are to the operating system; "-" is standard input or output, always PLY. Every reader throws
// InputError, naming the file, the place in it and what was expected; every writer throws OutputError and leaves
// either the complete file or the file that was there before (a temporary file is written and renamed).
//
// Coordinates in files are world coordinates. Points and meshes are returned in the identity frame. Mixtures and
// covariance meshes that carry a frame in their header are returned in that frame, so that the same bits come back.

namespace gpsrecon {

enum class FileKind { points, mixture, covmesh, mesh };

/// What a file holds, told from the extension and header alone (a PLY with covariance columns is a mixture, with faces
/// too a covariance mesh, with faces only a mesh). Throws InputError.
FileKind probe_file(const std::string& path);

/// Points of a PLY (any dialect), XYZ/TXT/CSV or PCD file; the vertices of a mesh file. Rows that are not finite are kept:
/// they are for the caller to count and drop.
PointCloud read_points(const std::string& path);

Mixture read_mixture(const std::string& path);
CovMesh read_covmesh(const std::string& path);

/// A polygon soup of a PLY, OFF, OBJ or STL file (equal STL corners are merged).
Mesh read_mesh(const std::string& path);

/// How numbers are stored in PLY files.
enum class PlyEncoding { binary, ascii };

void write_points(const PointCloud& cloud, const std::string& path, PlyEncoding encoding = PlyEncoding::binary);
void write_mixture(const Mixture& mixture, const std::string& path, PlyEncoding encoding = PlyEncoding::binary);
void write_covmesh(const CovMesh& mesh, const std::string& path, PlyEncoding encoding = PlyEncoding::binary);

/// PLY, OFF, OBJ or STL by extension. Positions in PLY are `float`, or `double` where rounding to float would move a vertex
/// by more than 1e-6 of the bounding-box diagonal. OFF, OBJ and STL hold positions and faces (OBJ: normals too).
void write_mesh(const Mesh& mesh, const std::string& path, PlyEncoding encoding = PlyEncoding::binary);

/// Throws OutputError unless a file can be created at `path` (its folder exists and is writable, it is not a directory)
/// and its extension is one that `write_mesh` knows if `mesh_format` is set. Leaves nothing behind.
void check_writable(const std::string& path, bool mesh_format = false);

}  // namespace gpsrecon
