#include <gpsrecon/gps/attributes.h>

#include <gpsrecon/core/parallel.h>
#include <gpsrecon/gps/evaluate_data.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gpsrecon::internal {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// Labels with their weights. More labels than this do not meet at a sample; the lightest would be forgotten.
class Votes {
 public:
  static Votes Zero() { return {}; }  // NOLINT(readability-identifier-naming): as Eigen names it
  static Votes of(double label, double weight) {
    Votes votes;
    votes.add(label, weight);
    return votes;
  }
  Votes& operator+=(const Votes& other) {
    for (std::size_t k = 0; k < other.count_; ++k) add(other.label_[k], other.weight_[k]);
    return *this;
  }
  friend Votes operator+(Votes a, const Votes& b) { return a += b; }
  friend Votes operator-(Votes a, const Votes& b) { return a += -1.0 * b; }
  friend Votes operator*(double factor, Votes votes) {
    for (std::size_t k = 0; k < votes.count_; ++k) votes.weight_[k] *= factor;
    return votes;
  }
  double winner() const {
    std::size_t best = 0;
    for (std::size_t k = 1; k < count_; ++k)
      if (weight_[k] > weight_[best] || (weight_[k] == weight_[best] && label_[k] < label_[best])) best = k;
    return count_ > 0 ? label_[best] : missing;
  }

 private:
  void add(double label, double weight) {
    std::size_t k = 0;
    while (k < count_ && label_[k] != label) ++k;
    if (k == capacity) {
      k = static_cast<std::size_t>(std::min_element(weight_.begin(), weight_.end()) - weight_.begin());
      if (weight_[k] >= weight) return;
      weight_[k] = 0;
    } else if (k == count_) {
      ++count_;
    }
    label_[k] = label;
    weight_[k] += weight;
  }

  static constexpr std::size_t capacity = 8;
  std::array<double, capacity> label_{};
  std::array<double, capacity> weight_{};
  std::size_t count_ = 0;
};

/// Precision within the surface: the thin axis, the normal, says nothing about it.
std::vector<double> surface_precisions(const Mixture& control, const RunContext& context) {
  std::vector<double> precisions(control.size());
  parallel_for(control.size(), context, [&](std::size_t s) {
    const Vec3 variances = eigen_decomposition(control.covariances[s]).values;
    precisions[s] = 1 / variances[1] + 1 / variances[2];
  });
  return precisions;
}

template <class Surface>
std::vector<Color> interpolate_colors(const Surface& surface, const std::vector<Color>& colors,
                                      const std::vector<double>& weights, const RunContext& context) {
  using Sum = Eigen::Vector4d;  // Σ w (red, green, blue), Σ w
  std::vector<Sum> sums(colors.size());
  for (std::size_t s = 0; s < colors.size(); ++s)
    sums[s] = weights[s] * Sum(colors[s][0], colors[s][1], colors[s][2], 1);
  const std::vector<Sum> at_samples = surface.template to_samples<Sum>(sums, context);
  std::vector<Color> result(at_samples.size());
  for (std::size_t u = 0; u < result.size(); ++u)
    for (Eigen::Index k = 0; k < 3; ++k)
      result[u][static_cast<std::size_t>(k)] =
          static_cast<std::uint8_t>(std::lround(std::clamp(at_samples[u][k] / at_samples[u][3], 0.0, 255.0)));
  return result;
}

template <class Surface>
std::vector<double> interpolate_quantity(const Surface& surface, const std::vector<double>& values,
                                         const std::vector<double>& weights, const RunContext& context) {
  using Sum = Eigen::Vector2d;  // Σ w x, Σ w
  std::vector<Sum> sums(values.size(), Sum::Zero());
  for (std::size_t s = 0; s < values.size(); ++s)
    if (!is_missing(values[s])) sums[s] = weights[s] * Sum(values[s], 1);
  const std::vector<Sum> at_samples = surface.template to_samples<Sum>(sums, context);
  std::vector<double> result(at_samples.size());
  for (std::size_t u = 0; u < result.size(); ++u)
    result[u] = at_samples[u][1] > 0 ? at_samples[u][0] / at_samples[u][1] : missing;
  return result;
}

template <class Surface>
std::vector<double> vote_for_labels(const Surface& surface, const std::vector<double>& labels,
                                    const std::vector<double>& weights, const RunContext& context) {
  std::vector<Votes> votes(labels.size());
  for (std::size_t s = 0; s < labels.size(); ++s)
    if (!is_missing(labels[s])) votes[s] = Votes::of(labels[s], weights[s]);
  const std::vector<Votes> at_samples = surface.template to_samples<Votes>(votes, context);
  std::vector<double> result(at_samples.size());
  std::transform(at_samples.begin(), at_samples.end(), result.begin(), [](const Votes& v) { return v.winner(); });
  return result;
}

template <class Surface>
void interpolate(const Surface& surface, const Mixture& control, Mesh& refined, const RunContext& context) {
  if (control.colors.empty() && control.scalars.empty()) return;
  const std::vector<double> weights = surface_precisions(control, context);
  if (!control.colors.empty()) refined.colors = interpolate_colors(surface, control.colors, weights, context);
  for (const ScalarColumn& column : control.scalars) {
    const auto interpolate =
        column.kind == ScalarKind::label ? vote_for_labels<Surface> : interpolate_quantity<Surface>;
    refined.scalars.push_back({column.name, interpolate(surface, column.values, weights, context), column.kind});
  }
}

/// Samples of a surface at given parameters, with the interface of RefinementLevels.
struct ParameterSamples {
  const PatchTable& table;
  std::span<const SurfaceParameter> parameters;

  template <class T>
  std::vector<T> to_samples(std::span<const T> values, const RunContext& context) const {
    const std::vector<T> points = table.to_points<T>(table.to_base<T>(values, context), context);
    std::vector<T> samples(parameters.size());
    parallel_blocks(
        parameters.size(), context,
        [&](std::size_t, std::size_t begin, std::size_t end) {
          PatchRow<0> row;
          for (std::size_t i = begin; i < end; ++i) {
            if (parameters[i].patch == no_index) {
              samples[i] = values[i];
              continue;
            }
            table.point_weights(table.locate(parameters[i]), row);
            samples[i] = apply_row<T>(row.row(), points);
          }
        },
        evaluation_block);
    return samples;
  }
};

}  // namespace

void interpolate_attributes(const RefinementLevels<LoopScheme>& surface, const Mixture& control, Mesh& refined,
                            const RunContext& context) {
  interpolate(surface, control, refined, context);
}
void interpolate_attributes(const RefinementLevels<CatmullClarkScheme>& surface, const Mixture& control, Mesh& refined,
                            const RunContext& context) {
  interpolate(surface, control, refined, context);
}

void interpolate_attributes(const SurfaceEvaluator& surface, std::span<const SurfaceParameter> parameters,
                            const Mixture& control, Mesh& refined, const RunContext& context) {
  interpolate(ParameterSamples{surface.data().table, parameters}, control, refined, context);
}

}  // namespace gpsrecon::internal
