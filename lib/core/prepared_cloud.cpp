#include <gpsrecon/core/prepared_cloud.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/clean.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/estimate_scale.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/principal_axes.h>

namespace gpsrecon {

using namespace internal;
namespace {

void refuse_degenerate(const PointCloud& cloud) {
  const std::size_t n = cloud.size();
  if (n < 3) throw NoSurfaceError("no surface through " + count_of(n, "distinct point"));
  if (on_a_line(cloud.positions)) throw NoSurfaceError("all points lie on a line: no surface");
}

/// The points that are not among `dropped`, which are ascending.
std::vector<Index> all_but(const std::vector<Index>& dropped, std::size_t count) {
  std::vector<Index> kept;
  kept.reserve(count - dropped.size());
  for (Index i = 0, next = 0; i < count; ++i) {
    if (next < dropped.size() && dropped[next] == i)
      ++next;
    else
      kept.push_back(i);
  }
  return kept;
}

}  // namespace

LengthScale PreparedCloud::lengths() const {
  return {.diagonal = diagonal, .spacing = scale.spacing, .scene_to_local = 1 / cloud.frame.scale()};
}

PreparedCloud PreparedCloud::with_points(PointCloud points) const {
  PreparedCloud other;
  other.scale = scale;
  other.diagonal = diagonal;
  other.sensor = sensor;
  other.scale.spacing_at.resize(points.size());
  other.scale.noise_at.resize(points.size());
  std::vector<Neighbor> nearest;
  for (std::size_t i = 0; i < points.size(); ++i) {
    neighbors->nearest(points.positions[i], 1, nearest);
    other.scale.spacing_at[i] = scale.spacing_at[nearest.front().index];
    other.scale.noise_at[i] = scale.noise_at[nearest.front().index];
  }
  other.neighbors = std::make_shared<const Neighbors>(points.positions);
  other.cloud = std::move(points);
  return other;
}

PreparedCloud prepare(const PointCloud& world, const ScaleOptions& options, const RunContext& context) {
  CleanCloud clean = internal::clean(world, context);
  PreparedCloud prepared;
  prepared.rows = world.size();
  prepared.non_finite = clean.non_finite;
  prepared.duplicates = clean.duplicates;
  prepared.cloud = std::move(clean.cloud);
  prepared.source = std::move(clean.source);
  refuse_degenerate(prepared.cloud);
  prepared.neighbors = std::make_shared<const Neighbors>(prepared.cloud.positions);
  prepared.scale = estimate_scale(prepared.cloud, *prepared.neighbors, options, context);
  const std::vector<Index>& isolated = prepared.scale.isolated;
  prepared.isolated = isolated.size();
  if (!isolated.empty()) {
    std::vector<Index> kept = all_but(isolated, prepared.cloud.size());
    prepared.cloud = select(prepared.cloud, kept);
    for (std::vector<double>* lengths : {&prepared.scale.spacing_at, &prepared.scale.noise_at}) {
      for (std::size_t i = 0; i < kept.size(); ++i) (*lengths)[i] = (*lengths)[kept[i]];
      lengths->resize(kept.size());
    }
    for (Index& k : kept) k = prepared.source[k];
    prepared.source = std::move(kept);
    refuse_degenerate(prepared.cloud);
    prepared.neighbors = std::make_shared<const Neighbors>(prepared.cloud.positions);
  }
  prepared.diagonal = bounding_box_diagonal(prepared.cloud.positions);
  context.log(LogLevel::info, "points: " + std::to_string(prepared.rows) + " read, " +
                                  std::to_string(prepared.cloud.size()) + " distinct ones used; dropped " +
                                  std::to_string(prepared.non_finite) + " not finite, " +
                                  std::to_string(prepared.isolated) + " isolated; merged " +
                                  std::to_string(prepared.duplicates) + " duplicates");
  return prepared;
}

}  // namespace gpsrecon
