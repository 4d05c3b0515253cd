// The product of Gaussians as linear subdivision of dual points: Preiner et al. 2019, section 4, Eq. 11-13.

#include <gpsrecon/gps/limit_surface.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/refinement_levels.h>
#include <gpsrecon/gps/surface_samples.h>
#include <numeric>

namespace gpsrecon::internal {

LimitSurface::LimitSurface(const FaceList& faces, std::size_t control_count, int levels, const SurfaceRules& rules,
                           const RunContext& context)
    : LimitSurface(manifold_connectivity(faces, control_count, "subdivision"), levels, rules, context) {}

LimitSurface::LimitSurface(const Connectivity& control, int levels, const SurfaceRules& rules,
                           const RunContext& context)
    : control_count_(control.vertex_count) {
  check_levels(control, levels, rules);
  const auto store = [&](const auto& refinement) {
    for (std::size_t level = 0; level < refinement.levels(); ++level)
      steps_.push_back(tabulate(refinement.step(level), context));
    limit_ = tabulate(refinement.limit(), context);
    connectivity_ = refinement.last(context);
    faces_ = face_list(connectivity_);
  };
  if (rules.scheme == Scheme::loop)
    store(RefinementLevels<LoopScheme>(control, levels, rules, context));
  else
    store(RefinementLevels<CatmullClarkScheme>(control, levels, rules, context));
}

SurfaceSamples LimitSurface::evaluate(const Mixture& control, bool limit, const RunContext& context) const {
  if (control.size() != control_count_)
    throw InvariantError("limit surface: " + std::to_string(control.size()) + " Gaussians for " +
                         std::to_string(control_count_) + " control vertices");
  const Normalization normal_form = normalization(control);
  std::vector<DualPoint> dual = dual_points(control, normal_form, context);
  for (const auto& step : steps_) dual = refine_values<DualPoint>(step, dual, context);
  return surface_samples(limit_, dual, normal_form, control.sigma0, faces_, {.limit = limit, .spread = true}, context);
}

std::vector<Index> LimitSurface::control_of_samples() const {
  std::vector<Index> control(control_count_);
  std::iota(control.begin(), control.end(), Index{0});
  const auto smallest = [&](std::span<const Index> of) {
    Index least = no_index;
    for (const Index v : of) least = std::min(least, control[v]);
    return least;
  };
  for (const auto& [faces, points] : steps_) {
    // After the vertices come the edges, whose rows begin with their two ends, and the faces.
    for (std::size_t r = faces.columns; r < points.rows(); ++r)
      control.push_back(smallest(points.row(r).indices.first(2)));
    for (std::size_t f = 0; f < faces.rows(); ++f) control.push_back(smallest(faces.row(f).indices));
  }
  return control;
}

}  // namespace gpsrecon::internal
