#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/io/io.h>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "console.h"
#include "inputs.h"
#include "outputs.h"

namespace gpsrecon::cli {

using namespace internal;
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// Bounding box and diagonal in world coordinates, of the finite positions.
void describe_positions(const std::vector<Vec3>& positions, const Frame& frame, Json& info) {
  std::size_t finite = 0;
  Box3 box;
  for (const Vec3& p : positions) {
    if (!p.allFinite()) continue;
    box.extend(frame.to_world(p));
    ++finite;
  }
  if (finite < positions.size()) info["non_finite"] = positions.size() - finite;
  if (finite == 0) return;
  info["bbox_min"] = json_of(box.min());
  info["bbox_max"] = json_of(box.max());
  info["diagonal"] = diagonal_length(box);
}

/// Names all columns among the attributes, and those that hold labels once more.
void describe_scalars(const std::vector<ScalarColumn>& scalars, Json& info) {
  for (const ScalarColumn& column : scalars) {
    info["attributes"].push_back(column.name);
    if (column.kind == ScalarKind::label) info["labels"].push_back(column.name);
  }
}

void describe(const PointCloud& cloud, Json& info) {
  info["points"] = cloud.size();
  describe_positions(cloud.positions, cloud.frame, info);
  Json& attributes = info["attributes"] = Json::array();
  if (!cloud.normals.empty()) attributes.push_back("normals");
  if (!cloud.colors.empty()) attributes.push_back("colors");
  if (!cloud.weights.empty()) attributes.push_back("weights");
  if (!cloud.sensors.empty()) attributes.push_back("sensors");
  describe_scalars(cloud.scalars, info);
}

void describe(const Mixture& mixture, Json& info) {
  info["components"] = mixture.size();
  double weight = 0;
  for (const double w : mixture.weights) weight += w;
  info["weight"] = weight;
  describe_positions(mixture.means, mixture.frame, info);
  info["attributes"] = Json::array();
  if (!mixture.normals.empty()) info["attributes"].push_back("normals");
  if (!mixture.colors.empty()) info["attributes"].push_back("colors");
  describe_scalars(mixture.scalars, info);
  const double scale = mixture.frame.scale();
  if (mixture.sigma0 > 0) info["sigma0"] = scale * mixture.sigma0;
  if (mixture.spacing > 0) info["spacing"] = scale * mixture.spacing;
  info["frame"] = {{"origin", json_of(mixture.frame.origin)}, {"exponent", mixture.frame.exponent}};
}

void describe_topology(const FaceList& faces, std::size_t vertices, Json& info) {
  const Topology t = topology(faces, vertices);
  info["topology"] = {{"faces", t.faces},
                      {"edges", t.edges},
                      {"used_vertices", t.vertices},
                      {"components", t.components},
                      {"euler", t.euler},
                      {"boundary_loops", t.boundary_loops},
                      {"boundary_edges", t.boundary_edges},
                      {"nonmanifold_edges", t.nonmanifold_edges},
                      {"nonmanifold_vertices", t.nonmanifold_vertices},
                      {"inconsistent_edges", t.inconsistent_edges},
                      {"manifold", t.manifold()},
                      {"triangular", faces.is_triangular()}};
}

void describe(const SurfaceRules& rules, Json& info) {
  info["surface"] = {{"scheme", rules.scheme == Scheme::loop ? "loop" : "catmull-clark"},
                     {"loop_weights", rules.weights == LoopWeights::loop ? "loop" : "warren"},
                     {"corners", rules.corners == CornerRule::smooth ? "smooth" : "sharp"}};
}

void describe(const CovMesh& mesh, Json& info) {
  describe(mesh.vertices, info);
  describe(mesh.rules, info);
  describe_topology(mesh.faces, mesh.vertices.size(), info);
}

void describe(const Mesh& mesh, Json& info) {
  info["vertices"] = mesh.positions.size();
  describe_positions(mesh.positions, mesh.frame, info);
  Json& attributes = info["attributes"] = Json::array();
  if (!mesh.normals.empty()) attributes.push_back("normals");
  if (!mesh.colors.empty()) attributes.push_back("colors");
  if (!mesh.sigma.empty()) attributes.push_back("sigma");
  describe_scalars(mesh.scalars, info);
  describe_topology(mesh.faces, mesh.positions.size(), info);
}

Json info_of(const std::string& path) {
  Json info = {{"file", path}};
  const auto describe_as = [&](const char* kind, const auto& data) {
    info["kind"] = kind;
    describe(data, info);
  };
  switch (kind_of(path)) {
    case FileKind::points:
      describe_as("points", read_points(path));
      break;
    case FileKind::mixture:
      describe_as("mixture", load_mixture(path));
      break;
    case FileKind::covmesh:
      describe_as("covmesh", load_covmesh(path));
      break;
    case FileKind::mesh:
      describe_as("mesh", load_mesh(path));
      break;
  }
  return info;
}

std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return number(value.get<double>(), 9);
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const Json& item : value) {
    if (!text.empty()) text += ' ';
    text += text_of(item);
  }
  return text.empty() ? "none" : text;
}

void print_for_people(const Json& info, int indent) {
  for (const auto& [name, value] : info.items()) {
    std::string label = std::string(static_cast<std::size_t>(indent), ' ') + name;
    std::replace(label.begin(), label.end(), '_', ' ');
    if (value.is_object()) {
      std::cout << label << "\n";
      print_for_people(value, indent + 2);
    } else {
      label.resize(std::max<std::size_t>(24, label.size() + 1), ' ');
      std::cout << label << text_of(value) << "\n";
    }
  }
}

struct InfoOptions {
  bool json = false;

  static OptionTable fields() {
    return {field<&InfoOptions::json>("json", "", "print a JSON list with one object per file")};
  }
};

}  // namespace

ExitCode run_info(Arguments& arguments) {
  std::vector<std::string> files;
  InfoOptions options;
  arguments.positionals("FILE", files, "points, mixture, covariance mesh or mesh (- is standard input)");
  arguments.group("Output", false);
  arguments.fields(options);
  const GlobalOptions globals = arguments.parse();
  std::vector<NamedFile> inputs;
  inputs.reserve(files.size());
  for (const std::string& file : files) inputs.push_back({"FILE", file});
  Outputs outputs(globals, std::move(inputs));
  outputs.plan({"the answer", "-"});
  const Console console(globals);

  Json all = Json::array();
  for (const std::string& file : files) all.push_back(info_of(file));
  if (options.json) {
    std::cout << all.dump(2) << "\n";
  } else {
    for (const Json& info : all) {
      if (&info != &all.front()) std::cout << "\n";
      print_for_people(info, 0);
    }
  }
  if (!std::cout.flush()) throw OutputError("standard output: cannot be written");
  return ExitCode::done;
}

}  // namespace gpsrecon::cli
