#include "inputs.h"

#include <gpsrecon/report/file_hash.h>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include "cancellation.h"
#include "repair.h"

namespace gpsrecon::cli {

using namespace internal;
namespace {

template <class Data, class Read>
Data load_valid(const std::string& path, const Read& read) {
  const EndAtOnceOnSignal nothing_written_yet;
  try {
    Data data = read(path);
    validate(data);
    return data;
  } catch (const InvariantError& error) {
    throw InputError(path + ": " + error.what());
  }
}

}  // namespace

FileKind kind_of(const std::string& path) {
  const EndAtOnceOnSignal nothing_written_yet;
  return probe_file(path);
}

PointCloud load_points(const std::string& path, const Console& console, const AttributeOptions& attributes) {
  const EndAtOnceOnSignal nothing_written_yet;
  const FileKind kind = probe_file(path);
  switch (kind) {
    case FileKind::points:
      break;
    case FileKind::mesh:
      console.warn(path + ": is a mesh; its vertices are taken as points");
      break;
    case FileKind::mixture:
      console.warn(path + ": is a mixture; its means are taken as points");
      break;
    case FileKind::covmesh:
      console.warn(path + ": is a covariance mesh; its means are taken as points");
      break;
  }
  PointCloud points = read_points(path);
  // The numbers of a Gaussian say nothing about a point.
  if (kind == FileKind::mixture || kind == FileKind::covmesh) points.scalars.clear();
  if (attributes.no_data) mark_missing(points.scalars, *attributes.no_data);
  mark_labels(points.scalars, attributes.labels);
  return points;
}

Mixture load_mixture(const std::string& path) {
  return load_valid<Mixture>(path, read_mixture);
}
CovMesh load_covmesh(const std::string& path) {
  return load_valid<CovMesh>(path, [](const std::string& file) { return read_covmesh(file); });
}
CovMesh load_covmesh(const std::string& path, bool repair, const Console& console) {
  if (!repair) return load_covmesh(path);
  return load_valid<CovMesh>(
      path, [&](const std::string& file) { return repaired(read_covmesh(file, false), file, console); });
}
void require_triangles(const CovMesh& mesh, const std::string& path, const std::string& reason) {
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    if (const std::size_t corners = mesh.faces[f].size(); corners != 3)
      throw InputError(path + ": face " + std::to_string(f) + " has " + std::to_string(corners) + " corners; " +
                       reason);
}
Mesh load_soup(const std::string& path) {
  const EndAtOnceOnSignal nothing_written_yet;
  return read_mesh(path);
}
Mesh load_mesh(const std::string& path) {
  return load_valid<Mesh>(path, read_mesh);
}

FileReport file_report(const std::string& path) {
  if (path == "-") return {path, "ply", ""};
  std::string format = std::filesystem::path(path).extension().string();
  std::transform(format.begin(), format.end(), format.begin(), [](unsigned char c) { return std::tolower(c); });
  // A pipe or a device has been read and cannot be read again.
  const bool can_be_read_again = std::filesystem::is_regular_file(path);
  return {path, format.empty() ? format : format.substr(1), can_be_read_again ? hash_file(path) : ""};
}

}  // namespace gpsrecon::cli
