#pragma once

#include <gpsrecon/core/mesh.h>
#include <string>

#include "arguments.h"
#include "console.h"

namespace gpsrecon::cli {

struct RepairOptions {
  bool repair = false;

  static OptionTable fields() {
    return {field<&RepairOptions::repair>(
        "repair", "",
        "make the faces manifold first: part what meets in an edge of more than two faces or only in a vertex, turn "
        "faces "
        "that disagree with their neighbours, tear what has one side only; a warning counts it")};
  }
};

/// Faces made manifold, with a warning that says what that took. Colours and scalars travel with the vertices; normals
/// do not. Gaussians that are copied share their weight.
Mesh repaired(const Mesh& mesh, const std::string& path, const Console& console);
CovMesh repaired(const CovMesh& mesh, const std::string& path, const Console& console);

}  // namespace gpsrecon::cli
