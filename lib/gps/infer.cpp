// Preiner et al. 2019, section 6.1, Eq. 15 (vertex-based), 16 and 17 (face-based).

#include <gpsrecon/gps/infer.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/order_statistics.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>

namespace gpsrecon {

using namespace internal;
namespace {

/// A face counts as degenerate when it is this much narrower (in variance) than long.
constexpr double degenerate_ratio = 1e-14;
/// The smallest relative bias, which an absolute one does not go below either.
constexpr double min_bias = 1e-9;

/// σ0² I of Eq. 15 and 17, as a multiple of the largest eigenvalue or in squares of the unit of the positions.
struct Bias {
  double relative, absolute;

  Sym3 added_to(const Sym3& covariance) const {
    // Needs the largest eigenvalue in full: flat, round neighbourhoods are common, and there closed formulas lose half
    // of the digits.
    const double largest = eigen_decomposition(covariance).values[2];
    return covariance + Sym3::identity(std::max(relative * largest, absolute));
  }
};

Bias bias_of(const InferOptions& options, const Mesh& mesh) {
  if (options.sigma0.is_automatic()) return {options.bias.value_or(InferOptions::default_bias), 0};
  const double sigma0 = options.sigma0.resolve(
      {.diagonal = bounding_box_diagonal(mesh.positions), .scene_to_local = 1 / mesh.frame.scale()}, "sigma0");
  return {min_bias, sigma0 * sigma0};
}

/// Population covariance of the corners of a face.
Sym3 corner_covariance(std::span<const Index> face, const std::vector<Vec3>& positions) {
  // Offsets from one of the corners are exact far from the origin, too.
  const Vec3& first = positions[face[0]];
  Vec3 mean = Vec3::Zero();
  for (const Index v : face) mean += positions[v] - first;
  mean /= static_cast<double>(face.size());
  Sym3 covariance;
  for (const Index v : face) covariance += Sym3::outer(positions[v] - first - mean);
  return covariance * (1 / static_cast<double>(face.size()));
}

bool is_degenerate(const Sym3& covariance) {
  const Vec3 values = eigen_decomposition(covariance).values;
  return !(values[1] > degenerate_ratio * values[2]);
}

/// Eq. 16 and 17: Σ = (Σ_j Σ_Δj⁻¹)⁻¹ over the faces j at a vertex; zero where there is none.
std::vector<Sym3> from_faces(const Mesh& mesh, const std::vector<Sym3>& face_covariances,
                             const std::vector<char>& degenerate, const Bias& bias, const RunContext& context) {
  std::vector<Sym3> face_precisions(mesh.faces.size());
  parallel_for(mesh.faces.size(), context, [&](std::size_t f) {
    if (!degenerate[f]) face_precisions[f] = Cholesky3(bias.added_to(face_covariances[f])).inverse();
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
std::vector<Sym3> from_neighbors(const Mesh& mesh, const std::vector<char>& degenerate, const Bias& bias,
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
  const Connectivity topology = build_connectivity(mesh.faces, mesh.positions.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    if (!degenerate[f])
      for (const Index v : mesh.faces[f]) moments[v].proper = true;
  for (const Index h : topology.edge_start) {
    add(topology.source(h), topology.target(h));
    add(topology.target(h), topology.source(h));
  }
  std::vector<Sym3> covariances(moments.size());
  parallel_for(moments.size(), context, [&](std::size_t v) {
    const Moments& m = moments[v];
    if (m.proper) covariances[v] = bias.added_to(m.squares * (1 / m.count) - Sym3::outer(m.sum / m.count));
  });
  return covariances;
}

bool is_known(const Sym3& covariance) {
  return covariance.trace() > 0;
}

/// The neighbours of every vertex whose covariance is not known.
std::vector<std::vector<Index>> neighbors_of_unknown(const FaceList& faces, const std::vector<Sym3>& covariances) {
  std::vector<std::vector<Index>> neighbors(covariances.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    for (std::size_t k = 0; k < face.size(); ++k) {
      const Index a = face[k], b = face[(k + 1) % face.size()];
      if (!is_known(covariances[a])) neighbors[a].push_back(b);
      if (!is_known(covariances[b])) neighbors[b].push_back(a);
    }
  }
  for (std::vector<Index>& list : neighbors) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbors;
}

/// Gives vertices amid degenerate faces the mean precision of their neighbours, ring by ring from the outside: as Eq.
/// 16 does with faces, but for the number of them, so that they weigh as much as their neighbours.
void fill_from_neighbors(const FaceList& faces, std::vector<Sym3>& covariances) {
  const std::vector<std::vector<Index>> neighbors = neighbors_of_unknown(faces, covariances);
  std::vector<Index> ring;
  for (Index v = 0; v < neighbors.size(); ++v)
    if (std::any_of(neighbors[v].begin(), neighbors[v].end(), [&](Index n) { return is_known(covariances[n]); }))
      ring.push_back(v);
  while (!ring.empty()) {
    std::vector<Sym3> filled(ring.size());
    std::vector<Index> next;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      Sym3 precision;
      double count = 0;
      for (const Index n : neighbors[ring[i]]) {
        if (!is_known(covariances[n])) {
          next.push_back(n);
          continue;
        }
        precision += Cholesky3(covariances[n]).inverse();
        ++count;
      }
      filled[i] = Cholesky3(precision * (1 / count)).inverse();
    }
    for (std::size_t i = 0; i < ring.size(); ++i) covariances[ring[i]] = filled[i];
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    std::erase_if(next, [&](Index v) { return is_known(covariances[v]); });
    ring = std::move(next);
  }
}

/// Fills the zero covariances; returns how many there were.
std::size_t fill_missing(const FaceList& faces, std::vector<Sym3>& covariances) {
  std::vector<double> traces;
  for (const Sym3& covariance : covariances)
    if (is_known(covariance)) traces.push_back(covariance.trace());
  if (traces.empty()) throw NoSurfaceError("infer: the mesh has no face with an area");
  const std::size_t missing = covariances.size() - traces.size();
  if (missing == 0) return 0;
  fill_from_neighbors(faces, covariances);
  const Sym3 typical = Sym3::identity(median(traces) / 3);
  for (Sym3& covariance : covariances)
    if (!is_known(covariance)) covariance = typical;
  return missing;
}

}  // namespace

void InferOptions::check() const {
  check_fields(*this);
  if (bias && !sigma0.is_automatic()) throw OptionError("bias and sigma0 contradict each other");
  // Squares must neither overflow nor vanish.
  if (!sigma0.is_automatic() && !(sigma0.number() >= 1e-100 && sigma0.number() <= 1e100))
    throw OptionError("sigma0 must be in [1e-100, 1e100], not " + sigma0.text());
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

  const Bias bias = bias_of(options, mesh);
  Inference result;
  result.degenerate_faces = static_cast<std::size_t>(std::count(degenerate.begin(), degenerate.end(), 1));
  Mixture& vertices = result.mesh.vertices;
  vertices.covariances = options.method == InferMethod::face
                             ? from_faces(mesh, face_covariances, degenerate, bias, context)
                             : from_neighbors(mesh, degenerate, bias, context);
  result.vertices_without_neighborhood = fill_missing(mesh.faces, vertices.covariances);
  // Sums over many and very unlike faces may exceed what one face's bias allows for.
  for (Sym3& covariance : vertices.covariances) covariance = floor_eigenvalues(covariance, min_eigenvalue_ratio);
  vertices.means = mesh.positions;
  vertices.weights.assign(mesh.positions.size(), 1);
  vertices.colors = mesh.colors;
  vertices.scalars = mesh.scalars;
  vertices.frame = mesh.frame;
  result.mesh.faces = mesh.faces;
  result.mesh.rules = rules_for(mesh.faces);
  validate(result.mesh);
  return result;
}

}  // namespace gpsrecon
