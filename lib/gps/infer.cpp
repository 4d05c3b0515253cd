#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/gps/infer.h>
#include <algorithm>
#include <cmath>

namespace gpsrecon {
namespace {

/// A face counts as degenerate when it is this much narrower (in variance) than long.
constexpr double degenerate_ratio = 1e-14;

/// Population covariance of the corners of a face.
Sym3 corner_covariance(std::span<const Index> face, const std::vector<Vec3>& positions) {
  Vec3 mean = Vec3::Zero();
  for (const Index v : face) mean += positions[v];
  mean /= static_cast<double>(face.size());
  Sym3 covariance;
  for (const Index v : face) covariance += Sym3::outer(positions[v] - mean);
  return covariance * (1 / static_cast<double>(face.size()));
}

/// Needs the largest eigenvalue in full: flat, round neighbourhoods are common, and there closed formulas lose half of
/// the digits.
Sym3 biased(const Sym3& covariance, double bias) {
  return covariance + Sym3::identity(bias * eigen_decomposition(covariance).values[2]);
}

bool is_degenerate(const Sym3& covariance) {
  const Vec3 values = eigen_decomposition(covariance).values;
  return !(values[1] > degenerate_ratio * values[2]);
}

/// Eq. 16 and 17: Σ = (Σ_j Σ_Δj⁻¹)⁻¹ over the faces j at a vertex; zero where there is none.
std::vector<Sym3> from_faces(const Mesh& mesh, const std::vector<Sym3>& face_covariances,
                             const std::vector<char>& degenerate, double bias, const RunContext& context) {
  std::vector<Sym3> face_precisions(mesh.faces.size());
  parallel_for(mesh.faces.size(), context, [&](std::size_t f) {
    if (!degenerate[f]) face_precisions[f] = Cholesky3(biased(face_covariances[f], bias)).inverse();
  });
  std::vector<Sym3> sums(mesh.positions.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (const Index v : mesh.faces[f]) sums[v] += face_precisions[f];
  parallel_for(sums.size(), context, [&](std::size_t v) {
    if (sums[v].trace() > 0) sums[v] = Cholesky3(sums[v]).inverse();
  });
  return sums;
}

/// Eq. 15: population covariance of a vertex and its neighbours; zero where the vertex is in no proper face.
std::vector<Sym3> from_neighbors(const Mesh& mesh, const std::vector<char>& degenerate, double bias,
                                 const RunContext& context) {
  // Sums of the offsets to the neighbours: the vertex itself contributes a zero to each of them.
  struct Moments {
    double count = 1;
    Vec3 sum = Vec3::Zero();
    Sym3 squares;
    bool proper = false;
  };
  std::vector<Moments> moments(mesh.positions.size());
  const auto add = [&](Index v, Index neighbor) {
    const Vec3 offset = mesh.positions[neighbor] - mesh.positions[v];
    moments[v].count += 1;
    moments[v].sum += offset;
    moments[v].squares += Sym3::outer(offset);
  };
  const HalfEdges topology = half_edges(mesh.faces, mesh.positions.size());
  for (Index h = 0; h < topology.next.size(); ++h) {
    const Index a = mesh.faces.corners[h], b = mesh.faces.corners[topology.next[h]];
    if (!degenerate[topology.face[h]]) moments[a].proper = true;
    if (topology.opposite[h] != no_index && topology.opposite[h] < h) continue;
    add(a, b);
    add(b, a);
  }
  std::vector<Sym3> covariances(moments.size());
  parallel_for(moments.size(), context, [&](std::size_t v) {
    const Moments& m = moments[v];
    if (m.proper) covariances[v] = biased(m.squares * (1 / m.count) - Sym3::outer(m.sum / m.count), bias);
  });
  return covariances;
}

/// Fills the zero covariances; returns how many there were.
std::size_t fill_missing(std::vector<Sym3>& covariances) {
  std::vector<double> traces;
  for (const Sym3& covariance : covariances)
    if (covariance.trace() > 0) traces.push_back(covariance.trace());
  if (traces.empty()) throw NoSurfaceError("infer: the mesh has no face with an area");
  const auto median = traces.begin() + static_cast<std::ptrdiff_t>(traces.size() / 2);
  std::nth_element(traces.begin(), median, traces.end());
  for (Sym3& covariance : covariances)
    if (!(covariance.trace() > 0)) covariance = Sym3::identity(*median / 3);
  return covariances.size() - traces.size();
}

}  // namespace

void InferOptions::check() const {
  if (!(bias >= 1e-9 && bias <= 1e3)) throw OptionError("bias: " + std::to_string(bias) + " is not in [1e-9, 1000]");
}

Inference infer_covariances(const Mesh& mesh, const InferOptions& options, const RunContext& context) {
  options.check();
  validate(mesh);
  std::vector<Sym3> face_covariances(mesh.faces.size());
  std::vector<char> degenerate(mesh.faces.size());
  parallel_for(mesh.faces.size(), context, [&](std::size_t f) {
    face_covariances[f] = corner_covariance(mesh.faces[f], mesh.positions);
    degenerate[f] = is_degenerate(face_covariances[f]) ? 1 : 0;
  });

  Inference result;
  result.degenerate_faces = static_cast<std::size_t>(std::count(degenerate.begin(), degenerate.end(), 1));
  Mixture& vertices = result.mesh.vertices;
  vertices.covariances = options.method == InferMethod::face
                             ? from_faces(mesh, face_covariances, degenerate, options.bias, context)
                             : from_neighbors(mesh, degenerate, options.bias, context);
  result.vertices_without_neighborhood = fill_missing(vertices.covariances);
  vertices.means = mesh.positions;
  vertices.weights.assign(mesh.positions.size(), 1);
  vertices.colors = mesh.colors;
  vertices.scalars = mesh.scalars;
  vertices.frame = mesh.frame;
  result.mesh.faces = mesh.faces;
  validate(result.mesh);
  return result;
}

}  // namespace gpsrecon
