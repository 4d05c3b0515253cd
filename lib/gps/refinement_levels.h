#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/gps/catmull_clark.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/loop.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <vector>

// Internal to lib/gps: uniform refinement with either scheme.

namespace gpsrecon::internal {

/// A map to nothing.
struct NoRows {
  using Weight = double;
  std::size_t column_count = 0;
  MaskStore<double> no_masks;

  std::size_t columns() const { return column_count; }
  std::size_t rows() const { return 0; }
  const MaskStore<double>& masks() const { return no_masks; }
  Mask mask(std::size_t) const { return {}; }
  void fill(std::size_t, std::span<Index>) const {}
};

struct LoopScheme {
  static void check(const Connectivity& connectivity) { check_triangles(connectivity); }
  static Connectivity refine(const Connectivity& parent, const RunContext& context) {
    return refine_triangles(parent, context);
  }
  static FaceList refined_faces(const Connectivity& parent, const RunContext& context) {
    return refined_triangles(parent, context);
  }
  static RefinementStep<NoRows, LoopRows> step(const Connectivity& connectivity, const SurfaceRules& rules) {
    return {{connectivity.vertex_count, {}}, {connectivity, rules.weights, rules.corners}};
  }
  static LoopLimitRows limit(const Connectivity& connectivity, const SurfaceRules& rules, bool refined) {
    return {connectivity, rules.weights, rules.corners, refined};
  }
};

struct CatmullClarkScheme {
  static void check(const Connectivity&) {}
  static Connectivity refine(const Connectivity& parent, const RunContext& context) {
    return refine_to_quads(parent, context);
  }
  static FaceList refined_faces(const Connectivity& parent, const RunContext& context) {
    return refined_quads(parent, context);
  }
  static RefinementStep<CatmullClarkFaceRows, CatmullClarkRows> step(const Connectivity& connectivity,
                                                                     const SurfaceRules& rules) {
    return {CatmullClarkFaceRows(connectivity), {connectivity, rules.corners}};
  }
  static CatmullClarkLimitRows limit(const Connectivity& connectivity, const SurfaceRules& rules, bool refined) {
    return {connectivity, rules.corners, refined};
  }
};

/// A step with its rows stored.
template <class FaceRows, class PointRows>
RefinementStep<StencilTable, StencilTable> tabulate(const RefinementStep<FaceRows, PointRows>& step,
                                                    const RunContext& context = {}) {
  return {tabulate(step.faces, context), tabulate(step.points, context)};
}

/// Refinement of one mesh by some levels. Nothing is stored but the connectivity of the levels between the first and
/// the last, about 30 bytes per vertex of the last: to be evaluated once. The samples are the vertices of the last
/// level.
template <class Scheme>
class RefinementLevels {
 public:
  /// `control` is manifold and consistently oriented, and must outlive this. Throws InvariantError if the scheme does
  /// not refine its faces. Precondition: levels >= 0.
  RefinementLevels(const Connectivity& control, int levels, const SurfaceRules& rules, const RunContext& context)
      : control_(control), levels_(static_cast<std::size_t>(levels)), rules_(rules) {
    Scheme::check(control);
    while (between_.size() + 1 < levels_) between_.push_back(Scheme::refine(above_last(), context));
  }

  std::size_t levels() const { return levels_; }
  /// From level `level` to the next.
  auto step(std::size_t level) const { return Scheme::step(level == 0 ? control_ : between_[level - 1], rules_); }
  /// Limits at the samples.
  auto limit() const { return Scheme::limit(above_last(), rules_, levels_ > 0); }
  FaceList faces(const RunContext& context) const {
    return levels_ > 0 ? Scheme::refined_faces(above_last(), context) : face_list(control_);
  }
  /// Connectivity of the last level.
  Connectivity last(const RunContext& context) const {
    return levels_ > 0 ? Scheme::refine(above_last(), context) : control_;
  }

  /// Values at the vertices of the last level, from those at control vertices.
  template <class T>
  std::vector<T> refine_to_last(std::vector<T> values, const RunContext& context) const {
    for (std::size_t level = 0; level < levels_; ++level) values = refine_values<T>(step(level), values, context);
    return values;
  }
  /// Limits at the samples, from values at control vertices.
  template <class T>
  std::vector<T> to_samples(std::span<const T> values, const RunContext& context) const {
    const std::vector<T> last = refine_to_last<T>({values.begin(), values.end()}, context);
    std::vector<T> samples(last.size());
    apply<T>(limit(), last, std::span<T>(samples), context, &LimitWeight::position);
    return samples;
  }

 private:
  /// The level above the last, or, without levels, the control mesh.
  const Connectivity& above_last() const { return between_.empty() ? control_ : between_.back(); }

  const Connectivity& control_;
  std::size_t levels_;
  SurfaceRules rules_;
  std::vector<Connectivity> between_;
};

/// Throws OptionError if a level is negative, has more faces than indices can count, or is 0 for
/// Scheme::catmull_clark and faces of other than four corners, whose limit positions have no masks.
void check_levels(const Connectivity& control, int levels, const SurfaceRules& rules);

}  // namespace gpsrecon::internal
