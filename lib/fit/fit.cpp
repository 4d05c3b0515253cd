// Iterated closest points on a subdivision surface, as Hoppe et al. 1994, with moves along the normals only.

#include <gpsrecon/fit/fit.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/core/orient.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/core/self_intersections.h>
#include <gpsrecon/fit/least_squares.h>
#include <gpsrecon/fit/refine.h>
#include <gpsrecon/fit/residuals.h>
#include <gpsrecon/fit/rim.h>
#include <gpsrecon/gps/limit_surface.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr double held_out_share = 1.0 / 16;
/// Fewer points cannot judge.
constexpr std::size_t min_held_out = 100;
constexpr std::uint64_t held_out_stream = 0x6669740000000000;
/// Steps end when one lowers the loss of the points it fits by less than this part.
constexpr double min_improvement = 0.0005;
/// A refinement is undone when the loss of the held-out points rises by more than this many standard errors. They are
/// not quite impartial: the mixture has seen them, and every move away from it costs them a little.
constexpr double significant_rise = 3;
/// Steps in the end on all points, held out or not.
constexpr int steps_on_all = 2;
/// Rounds of refinement end when fewer than this part of the edges show detail.
constexpr double min_split_share = 0.002;

/// Offsets below this part of the extent of the surface are rounding errors, in which there is no detail.
constexpr double rounding = 1e-13;

/// Points that do not take part, one in sixteen at random; none of a small cloud.
std::vector<char> hold_out(std::size_t points, std::uint64_t seed) {
  std::vector<char> held_out(points, 0);
  if (static_cast<double>(points) * held_out_share < min_held_out) return held_out;
  for (std::size_t i = 0; i < points; ++i)
    held_out[i] = random_uniform(seed, held_out_stream, i) < held_out_share ? 1 : 0;
  return held_out;
}

/// Biweight loss of each point, in [0, 1].
std::vector<double> point_losses(const Assignment& assignment, double scale, const RunContext& context) {
  std::vector<double> losses(assignment.offset.size());
  parallel_for(losses.size(), context, [&](std::size_t i) {
    const double d = assignment.offset[i];
    const double u = d != 0 ? d / (outlier_distance * scale) : 0;
    const double kept = std::max(0.0, 1 - u * u);
    losses[i] = 1 - kept * kept * kept;
  });
  return losses;
}

/// Mean loss of the points that are fitted.
double fitted_loss(const std::vector<double>& losses, const std::vector<char>& held_out) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < losses.size(); ++i) {
    if (held_out[i]) continue;
    sum += losses[i];
    ++count;
  }
  return sum / count;
}

/// By how many standard errors the held-out points' loss rose.
double held_out_rise(const std::vector<double>& before, const std::vector<double>& after,
                     const std::vector<char>& held_out) {
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!held_out[i]) continue;
    const double rise = after[i] - before[i];
    sum += rise;
    squares += rise * rise;
  }
  return squares > 0 ? sum / std::sqrt(squares) : 0;
}

double held_out_median(const Assignment& assignment, const std::vector<char>& held_out) {
  Assignment judges;
  for (std::size_t i = 0; i < held_out.size(); ++i)
    if (held_out[i]) judges.offset.push_back(assignment.offset[i]);
  return judges.offset.empty() ? 0 : median_offset(judges);
}

/// No mean leaves its own Gaussian, by more than this many of its standard deviations along the normal: at the tips of
/// sheets thinner than the noise points are taken for those of the other side, and drive the surface away.
constexpr double farthest_move = 3;
void stay_inside(const Mixture& control, const std::vector<Vec3>& normals, const std::vector<double>& moved,
                 std::vector<double>& moves) {
  for (std::size_t v = 0; v < moves.size(); ++v) {
    const double limit = farthest_move * std::sqrt(control.covariances[v].quadratic_form(normals[v]));
    moves[v] = std::clamp(moves[v], std::min(0.0, -limit - moved[v]), std::max(0.0, limit - moved[v]));
  }
}

/// Cosine of the largest angle by which a step may turn a face.
constexpr double largest_turn = 0.5;

/// Halves the moves of faces that would turn by more, and forbids them in the end, until none turns: a face between
/// shortened ones may turn only then. Returns how many faces that concerned.
std::size_t restrain(const CovMesh& mesh, const std::vector<Vec3>& normals, std::vector<double>& moves,
                     const RunContext& context) {
  const std::vector<Vec3>& means = mesh.vertices.means;
  std::vector<char> turns(mesh.faces.size()), ever(mesh.faces.size(), 0);
  constexpr int halvings = 6;
  for (int attempt = 0;; ++attempt) {
    parallel_for(mesh.faces.size(), context, [&](std::size_t f) {
      const auto t = mesh.faces[f];
      const auto moved = [&](Index v) -> Vec3 { return means[v] + moves[v] * normals[v]; };
      const Vec3 before = area_vector(means[t[0]], means[t[1]], means[t[2]]);
      const Vec3 after = area_vector(moved(t[0]), moved(t[1]), moved(t[2]));
      turns[f] = before.dot(after) < largest_turn * before.norm() * after.norm() ? 1 : 0;
    });
    bool any = false;
    std::vector<char> shorten(moves.size(), 0);
    for (std::size_t f = 0; f < turns.size(); ++f) {
      if (!turns[f]) continue;
      any = true;
      ever[f] = 1;
      for (const Index v : mesh.faces[f]) shorten[v] = 1;
    }
    if (!any) break;
    for (std::size_t v = 0; v < moves.size(); ++v)
      if (shorten[v]) moves[v] *= attempt < halvings ? 0.5 : 0;
  }
  return static_cast<std::size_t>(std::count(ever.begin(), ever.end(), 1));
}

/// Takes back moves of the vertices of faces that intersect others, by halves and in the end altogether. What
/// intersected before stays as it is. Returns the number of faces that concerned.
std::size_t untangle(CovMesh& mesh, const std::vector<Vec3>& means_before, std::vector<double>& moved,
                     const std::vector<double>& moved_before, const RunContext& context) {
  std::vector<Vec3>& means = mesh.vertices.means;
  constexpr int halvings = 3;
  std::size_t first = 0;
  for (int attempt = 0; attempt <= halvings; ++attempt) {
    const std::vector<Index> tangled = self_intersecting_faces(means, mesh.faces, context);
    if (attempt == 0) first = tangled.size();
    if (tangled.empty()) break;
    std::vector<char> concerned(means.size(), 0);
    for (const Index f : tangled)
      for (const Index v : mesh.faces[f]) concerned[v] = 1;
    const double kept = attempt < halvings ? 0.5 : 0;
    for (std::size_t v = 0; v < means.size(); ++v) {
      if (!concerned[v]) continue;
      means[v] = means_before[v] + kept * (means[v] - means_before[v]);
      moved[v] = moved_before[v] + kept * (moved[v] - moved_before[v]);
    }
  }
  return first;
}

/// What is known of the current control mesh.
struct FitState {
  std::vector<double> moved;   ///< per control vertex: its moves along the normal so far
  Assignment assignment;       ///< of the points to samples; between rounds, to control vertices
  std::vector<double> losses;  ///< of the points, see point_losses()
};

/// How many vertices may still be added.
std::size_t room(const CovMesh& mesh, const FitOptions& options) {
  const std::size_t n = mesh.vertices.size(), most = options.max_vertices > 0 ? options.max_vertices : no_index;
  return most - std::min(n, most);
}

/// What one control mesh after the other is fitted with.
struct Fitting {
  const PointCloud& cloud;
  const FitOptions& options;
  const RunContext& context;
  std::vector<char> held_out;
  double scale = 0;  ///< median offset before the first step, by which loss is measured

  FitState state = {};

  void assign(const SurfaceSamples& samples, const SampleGraph& graph, bool first);
  std::size_t step(CovMesh& mesh, const LimitSurface& surface, const ControlEdges& edges, const Rim& rim,
                   const SurfaceSamples& samples);
  std::vector<double> round(Fit& fit, int steps, Scheme scheme = Scheme::loop);
};

void Fitting::assign(const SurfaceSamples& samples, const SampleGraph& graph, bool first) {
  if (first) {
    state.assignment = assign_points(samples, cloud, context);
    scale = median_offset(state.assignment);
  } else {
    reassign_points(samples, graph, cloud, context, state.assignment);
  }
  state.losses = point_losses(state.assignment, scale, context);
}

/// Returns the number of faces it held back.
std::size_t Fitting::step(CovMesh& mesh, const LimitSurface& surface, const ControlEdges& edges, const Rim& rim,
                          const SurfaceSamples& samples) {
  const double typical = median_offset(state.assignment);
  const Residuals residuals = robust_residuals(surface, state.assignment, cloud, held_out, typical);
  std::vector<double> moves = solve_moves(surface, mesh.vertices, edges, samples, residuals, state.moved, context);
  stay_inside(mesh.vertices, samples.normals, state.moved, moves);
  const std::size_t restrained = restrain(mesh, samples.normals, moves, context);
  for (std::size_t v = 0; v < moves.size(); ++v) {
    mesh.vertices.means[v] += moves[v] * samples.normals[v];
    state.moved[v] += moves[v];
  }
  extend_rim(surface, rim, samples, state.assignment, cloud, outlier_distance * typical, mesh.vertices);
  return restrained;
}

/// Steps on one control mesh, until the points come no closer. Returns the evidence for more detail per control edge,
/// and hands the points over to the control vertices, which keep their numbers when edges are split.
/// Evidence there is with Scheme::loop only.
std::vector<double> Fitting::round(Fit& fit, int steps, Scheme scheme) {
  CovMesh& mesh = fit.mesh;
  const Connectivity& topology = fit.connectivity;
  SurfaceRules rules = mesh.rules;
  rules.scheme = scheme;
  const LimitSurface surface(topology, options.level, rules, context);
  const SampleGraph graph = sample_graph(surface);
  const Rim rim = find_rim(surface);
  const ControlEdges edges = control_edges(topology);
  state.moved.resize(mesh.vertices.size(), 0.0);
  SurfaceSamples samples = surface.evaluate(mesh.vertices, true, context);
  assign(samples, graph, fit.steps == 0);
  if (fit.steps == 0) fit.held_out_before = held_out_median(state.assignment, held_out);
  const std::vector<Vec3> means_before = mesh.vertices.means;
  const std::vector<double> moved_before = state.moved;
  double loss = fitted_loss(state.losses, held_out);
  for (int s = 0; s < steps; ++s) {
    const double loss_before = loss;
    fit.restrained_faces += step(mesh, surface, edges, rim, samples);
    ++fit.steps;
    samples = surface.evaluate(mesh.vertices, true, context);
    assign(samples, graph, false);
    loss = fitted_loss(state.losses, held_out);
    // The rim of an open surface still moves when the rest has come to rest.
    if (rim.sample.empty() && loss > (1 - min_improvement) * loss_before) break;
  }
  if (const std::size_t tangled = untangle(mesh, means_before, state.moved, moved_before, context); tangled > 0) {
    fit.restrained_faces += tangled;
    samples = surface.evaluate(mesh.vertices, true, context);
    assign(samples, graph, false);
  }
  if (scheme != Scheme::loop) return {};
  const double typical = median_offset(state.assignment);
  const Residuals residuals = robust_residuals(surface, state.assignment, cloud, held_out, typical);
  const std::vector<Index> control = surface.control_of_samples();
  for (Index& s : state.assignment.sample) s = control[s];
  if (typical <= rounding * bounding_box_diagonal(samples.positions))
    return std::vector<double>(topology.edge_count(), 0.0);
  return edges_with_detail(surface, topology, residuals);
}

/// Cloud and mesh are in one frame; lengths are in the units of the positions.
Fit fit_rounds(ConnectedMesh mesh, const PointCloud& cloud, const FitOptions& options, const RunContext& context) {
  Fit result;
  result.mesh = std::move(mesh.mesh);
  result.connectivity = std::move(mesh.connectivity);
  std::vector<char> held_out = hold_out(cloud.size(), context.seed);
  result.held_out_points = static_cast<std::size_t>(std::count(held_out.begin(), held_out.end(), 1));
  Fitting fitting{.cloud = cloud, .options = options, .context = context, .held_out = std::move(held_out)};
  // As they were before a refinement, in case it is undone.
  CovMesh coarser;
  Connectivity coarser_connectivity;
  FitState accepted;
  for (int round = 0;; ++round) {
    const std::vector<double> detail = fitting.round(result, options.steps);
    if (round > 0) {
      if (held_out_rise(accepted.losses, fitting.state.losses, fitting.held_out) > significant_rise) {
        result.mesh = std::move(coarser);
        result.connectivity = std::move(coarser_connectivity);
        fitting.state = std::move(accepted);
        break;
      }
      ++result.refinements;
      result.added_vertices += result.mesh.vertices.size() - coarser.vertices.size();
    }
    result.held_out_after = held_out_median(fitting.state.assignment, fitting.held_out);
    context.progress("fit", static_cast<double>(round + 1) / (options.refinements + 2));
    const auto shown = static_cast<double>(detail.size() - std::count(detail.begin(), detail.end(), 0.0));
    if (round == options.refinements || shown <= min_split_share * static_cast<double>(detail.size())) break;
    const std::vector<char> split =
        strongest_edges(result.mesh, result.connectivity, detail, room(result.mesh, options));
    if (std::count(split.begin(), split.end(), 1) == 0) break;
    accepted = fitting.state;
    coarser = std::move(result.mesh);
    coarser_connectivity = std::move(result.connectivity);
    result.mesh = split_edges(coarser, coarser_connectivity, split, context);
    result.connectivity = build_connectivity(result.mesh.faces, result.mesh.vertices.size());
  }
  const bool other_scheme = result.mesh.rules.scheme != Scheme::loop;
  if (result.held_out_points > 0 || other_scheme) {
    fitting.held_out.assign(cloud.size(), 0);
    fitting.round(result, other_scheme ? options.steps : std::min(options.steps, steps_on_all),
                  result.mesh.rules.scheme);
  }
  context.progress("fit", 1);
  return result;
}

/// Per point a vector to the outer side: the way to the sensor that was given, else to the point's own, else its
/// normal. Empty if nothing tells.
std::vector<Vec3> outward_directions(const PointCloud& cloud, const std::optional<Vec3>& sensor) {
  if (!sensor && cloud.sensors.empty()) return cloud.normals;
  const Vec3 at = sensor ? cloud.frame.to_local(*sensor) : Vec3::Zero();
  std::vector<Vec3> directions(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) directions[i] = (sensor ? at : cloud.sensors[i]) - cloud.positions[i];
  return directions;
}

}  // namespace

Fit fit(ConnectedMesh mesh, const PointCloud& cloud, const FitOptions& options, const RunContext& context) {
  options.check();
  if (options.steps == 0 || cloud.empty() || mesh.mesh.faces.empty()) {
    Fit same;
    same.mesh = std::move(mesh.mesh);
    same.connectivity = std::move(mesh.connectivity);
    return same;
  }
  const Frame& frame = mesh.mesh.vertices.frame;
  if (!(cloud.frame == frame)) {
    const PointCloud local = in_frame(cloud, frame);
    return fit(std::move(mesh), local, options, context);
  }
  const std::vector<Vec3> before = mesh.mesh.vertices.means;
  Fit result = fit_rounds(std::move(mesh), cloud, options, context);
  Mixture& vertices = result.mesh.vertices;
  vertices = as_stored(vertices);
  const double unit = vertices.frame.scale();
  result.held_out_before *= unit;
  result.held_out_after *= unit;
  for (std::size_t v = 0; v < before.size(); ++v) {
    const double shift = unit * (vertices.means[v] - before[v]).norm();
    result.mean_shift += shift / static_cast<double>(before.size());
    result.max_shift = std::max(result.max_shift, shift);
  }
  context.log(LogLevel::info, "fit: " + std::to_string(result.steps) + " steps, " +
                                  std::to_string(result.added_vertices) + " vertices added in " +
                                  std::to_string(result.refinements) + " refinements");
  return result;
}

Fit fit(ConnectedMesh mesh, const PreparedCloud& cloud, const FitOptions& options, const RunContext& context) {
  const Frame& frame = mesh.mesh.vertices.frame;
  const PointCloud points = cloud.cloud.frame == frame ? PointCloud() : in_frame(cloud.cloud, frame);
  const PointCloud& local = points.empty() ? cloud.cloud : points;
  std::size_t turned = 0;
  if (const std::vector<Vec3> directions = outward_directions(local, cloud.sensor); !directions.empty())
    turned = orient_by_vote(mesh.mesh.vertices, mesh.mesh.faces, mesh.connectivity, local, directions, context);
  Fit result = fit(std::move(mesh), local, options, context);
  result.flipped_components = turned;
  return result;
}

}  // namespace gpsrecon
