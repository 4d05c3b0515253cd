#pragma once

#include <gpsrecon/core/mesh.h>
#include <string>

#include "arguments.h"
#include "console.h"

namespace gpsrecon::cli {

void bind_repair(Arguments& arguments, bool& repair);

/// Faces made manifold, with a warning that says what that took. Colours and scalars travel with the vertices; normals
/// do not. Gaussians that are copied share their weight.
Mesh repaired(const Mesh& mesh, const std::string& path, const Console& console);
CovMesh repaired(const CovMesh& mesh, const std::string& path, const Console& console);

}  // namespace gpsrecon::cli
