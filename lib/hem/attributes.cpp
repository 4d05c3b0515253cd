#include <gpsrecon/core/parallel.h>
#include <gpsrecon/hem/attributes.h>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gpsrecon {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// The points of component s are point[offset[s] .. offset[s + 1]), ascending.
struct Members {
  std::vector<std::size_t> offset;
  std::vector<Index> point;

  Members(std::span<const Index> component_of, std::size_t components)
      : offset(components + 1, 0), point(component_of.size()) {
    for (const Index s : component_of) ++offset[s + 1];
    for (std::size_t s = 0; s < components; ++s) offset[s + 1] += offset[s];
    std::vector<std::size_t> next(offset.begin(), offset.end() - 1);
    for (std::size_t i = 0; i < component_of.size(); ++i) point[next[component_of[i]]++] = static_cast<Index>(i);
  }
  std::span<const Index> operator[](std::size_t s) const {
    return {point.data() + offset[s], point.data() + offset[s + 1]};
  }
};

Color mean_color(const PointCloud& cloud, std::span<const Index> points) {
  Vec3 sum = Vec3::Zero();
  double weight = 0;
  for (const Index i : points) {
    const Color& c = cloud.colors[i];
    sum += cloud.weight(i) * Vec3(c[0], c[1], c[2]);
    weight += cloud.weight(i);
  }
  Color mean{};
  for (std::size_t k = 0; k < 3; ++k)
    mean[k] = static_cast<std::uint8_t>(std::lround(sum[static_cast<Eigen::Index>(k)] / weight));
  return mean;
}

double mean_value(const PointCloud& cloud, const std::vector<double>& values, std::span<const Index> points) {
  double sum = 0, weight = 0;
  for (const Index i : points) {
    if (is_missing(values[i])) continue;
    sum += cloud.weight(i) * values[i];
    weight += cloud.weight(i);
  }
  return weight > 0 ? sum / weight : missing;
}

double majority(const PointCloud& cloud, const std::vector<double>& values, std::span<const Index> points) {
  std::vector<Index> ordered;
  for (const Index i : points)
    if (!is_missing(values[i])) ordered.push_back(i);
  std::stable_sort(ordered.begin(), ordered.end(), [&](Index a, Index b) { return values[a] < values[b]; });
  double winner = missing, most = 0;
  for (std::size_t begin = 0, end = 0; begin < ordered.size(); begin = end) {
    double weight = 0;
    for (; end < ordered.size() && values[ordered[end]] == values[ordered[begin]]; ++end)
      weight += cloud.weight(ordered[end]);
    if (weight > most) {
      most = weight;
      winner = values[ordered[begin]];
    }
  }
  return winner;
}

}  // namespace

void carry_attributes(const PointCloud& cloud, std::span<const Index> component_of, Mixture& mixture,
                      const RunContext& context) {
  const Members members(component_of, mixture.size());
  if (!cloud.colors.empty()) {
    mixture.colors.resize(mixture.size());
    parallel_for(mixture.size(), context, [&](std::size_t s) { mixture.colors[s] = mean_color(cloud, members[s]); });
  }
  for (const ScalarColumn& column : cloud.scalars) {
    const auto combine = column.kind == ScalarKind::label ? majority : mean_value;
    std::vector<double> values(mixture.size());
    parallel_for(mixture.size(), context,
                 [&](std::size_t s) { values[s] = combine(cloud, column.values, members[s]); });
    mixture.scalars.push_back({column.name, std::move(values), column.kind});
  }
}

}  // namespace gpsrecon
