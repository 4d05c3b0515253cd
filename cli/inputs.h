#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/gps/subdivide.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/report/report.h>
#include <optional>
#include <string>
#include <vector>

#include "console.h"

namespace gpsrecon::cli {

// Reading for commands: what the library reads, checked so that invalid data is an InputError that names the file.
// A signal while they read ends the program at once.

/// What the file holds.
FileKind kind_of(const std::string& path);

/// What the files do not say about the columns of points.
struct AttributeOptions {
  std::vector<std::string> labels = {};
  std::optional<double> no_data = {};

  static OptionTable fields() {
    return {field<&AttributeOptions::labels>("labels", "",
                                             "columns of whole numbers that are labels: decided by majority, never "
                                             "averaged; those named class, label, segment and the like are anyway"),
            field<&AttributeOptions::no_data>(
                "no-data", "", "number that stands for a missing one in columns of scalars, besides NaN")};
  }
};

/// Points, or with a warning the vertices of a mesh and the means of a mixture.
PointCloud load_points(const std::string& path, const Console& console, const AttributeOptions& attributes = {});
Mixture load_mixture(const std::string& path);
CovMesh load_covmesh(const std::string& path);
/// load_covmesh(), or with `repair` one whose faces need not be manifold, made so.
CovMesh load_covmesh(const std::string& path, bool repair, const Console& console);
/// InputError, naming the first other face and `reason`, unless all are triangles.
void require_triangles(const CovMesh& mesh, const std::string& path, const std::string& reason);
Mesh load_mesh(const std::string& path);
/// What is to be repaired first: nothing is promised of its faces but corners in range.
Mesh load_soup(const std::string& path);

/// Runs `work` on what a file holds, and puts the name of the file into its complaints about that.
template <class Work>
auto on_data_of(const std::string& path, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what());
  } catch (const NoSurfaceError& error) {
    throw NoSurfaceError(path + ": " + error.what());
  }
}

/// How a file that was read is called in a report.
FileReport file_report(const std::string& path);

}  // namespace gpsrecon::cli
