// Normal equations by conjugate gradients: Hestenes & Stiefel 1952.

#include <gpsrecon/fit/least_squares.h>

#include <gpsrecon/core/parallel.h>
#include <cmath>
#include <limits>

namespace gpsrecon::internal {
namespace {

/// What the mixture says about a mean counts as much as one point does,
constexpr double anchor_weight = 1;
/// and that it should move as its neighbours do, as three, shared by the six edges of a regular vertex.
constexpr double coupling_weight = 3.0 / 6;
/// Both priors are heavy-tailed: they hold moves that could be noise and let go of significant ones (Cauchy; the number
/// is the squared move, in its own variance, that halves their weight, inverted).
constexpr double significance = 0.2;
/// The weights and the normals change from step to step, so that more iterations than these gain nothing in the end.
constexpr int iterations = 3;

/// Priors on the moves, as weights of quadratic terms (majorise-minimise).
struct Priors {
  const ControlEdges& edges;
  std::vector<double> anchor;    ///< per vertex
  std::vector<double> coupling;  ///< per edge

  /// out += sign · P x
  void add(const std::vector<double>& x, double sign, std::vector<double>& out) const {
    for (std::size_t i = 0; i < x.size(); ++i) out[i] += sign * anchor[i] * x[i];
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto [a, b] = edges[e];
      const double pull = sign * coupling[e] * (x[a] - x[b]);
      out[a] += pull;
      out[b] -= pull;
    }
  }
  std::vector<double> diagonal() const {
    std::vector<double> d = anchor;
    for (std::size_t e = 0; e < edges.size(); ++e)
      for (const Index end : edges[e]) d[end] += coupling[e];
    return d;
  }
};

/// Variances of the average offset around each vertex, from the scatter of its points; infinite where there are none.
std::vector<double> move_variances(const LimitSurface& surface, const Residuals& residuals) {
  const std::vector<double> points = surface.to_control<double>(residuals.weight);
  std::vector<double> variance = surface.to_control<double>(residuals.square);
  for (std::size_t i = 0; i < variance.size(); ++i)
    variance[i] = points[i] > 0 ? variance[i] / (points[i] * points[i]) : std::numeric_limits<double>::infinity();
  return variance;
}

Priors make_priors(const ControlEdges& edges, const std::vector<double>& moved, const std::vector<double>& variance) {
  const auto hold = [](double move, double var) {
    return move == 0 || std::isinf(var) ? 1 : var / (var + significance * move * move);
  };
  Priors priors{edges, std::vector<double>(moved.size()), std::vector<double>(edges.size())};
  for (std::size_t i = 0; i < moved.size(); ++i) priors.anchor[i] = anchor_weight * hold(moved[i], variance[i]);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto [a, b] = edges[e];
    priors.coupling[e] = coupling_weight * hold(moved[a] - moved[b], variance[a] + variance[b]);
  }
  return priors;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

ControlEdges control_edges(const Connectivity& topology) {
  ControlEdges edges;
  edges.reserve(topology.edge_count());
  for (const Index h : topology.edge_start) edges.push_back({topology.source(h), topology.target(h)});
  return edges;
}

std::vector<double> solve_moves(const LimitSurface& surface, const Mixture& control, const ControlEdges& edges,
                                const SurfaceSamples& samples, const Residuals& residuals,
                                const std::vector<double>& moved, const RunContext& context) {
  const std::size_t n = control.size(), m = surface.sample_count();
  std::vector<Vec3> lever(n);  // Σ_i⁻¹ n_i
  parallel_for(n, context,
               [&](std::size_t i) { lever[i] = Cholesky3(control.covariances[i]).solve(samples.normals[i]); });
  const Priors priors = make_priors(edges, moved, move_variances(surface, residuals));

  std::vector<Vec3> at_samples(m), at_control(n);
  const auto transposed = [&](const std::vector<double>& y) {  // Aᵀ y
    parallel_for(m, context, [&](std::size_t s) { at_samples[s] = y[s] * samples.spread[s]; });
    const std::vector<Vec3> pulled = surface.to_control<Vec3>(at_samples);
    std::vector<double> out(n);
    for (std::size_t i = 0; i < n; ++i) out[i] = lever[i].dot(pulled[i]);
    return out;
  };
  std::vector<double> y(m);
  const auto normal_matrix = [&](const std::vector<double>& x) {  // (Aᵀ W A + P) x
    parallel_for(n, context, [&](std::size_t i) { at_control[i] = x[i] * lever[i]; });
    const std::vector<Vec3> followed = surface.to_samples<Vec3>(at_control, context);
    parallel_for(m, context, [&](std::size_t s) { y[s] = residuals.weight[s] * samples.spread[s].dot(followed[s]); });
    std::vector<double> out = transposed(y);
    priors.add(x, 1, out);
    return out;
  };

  // Preconditioned by the row sums of the normal matrix: one iteration is then the average of the offsets around a
  // vertex, and no row is left without weight.
  std::vector<double> r = transposed(residuals.moment), row_sum = transposed(residuals.weight);
  priors.add(moved, -1, r);
  const std::vector<double> prior_diagonal = priors.diagonal();
  for (std::size_t i = 0; i < n; ++i) row_sum[i] = std::max(row_sum[i], 0.0) + prior_diagonal[i];
  std::vector<double> x(n, 0.0), z(n);
  const auto precondition = [&] {
    for (std::size_t i = 0; i < n; ++i) z[i] = row_sum[i] > 0 ? r[i] / row_sum[i] : 0;
  };
  precondition();
  std::vector<double> direction = z;
  double rz = dot(r, z);
  for (int iteration = 0; iteration < iterations && rz > 0; ++iteration) {
    const std::vector<double> image = normal_matrix(direction);
    const double curvature = dot(direction, image);
    if (!(curvature > 0)) break;
    const double length = rz / curvature;
    for (std::size_t i = 0; i < n; ++i) {
      x[i] += length * direction[i];
      r[i] -= length * image[i];
    }
    precondition();
    const double next_rz = dot(r, z);
    for (std::size_t i = 0; i < n; ++i) direction[i] = z[i] + next_rz / rz * direction[i];
    rz = next_rz;
  }
  return x;
}

}  // namespace gpsrecon::internal
