#include <gpsrecon/hem/attributes.h>

#include <gpsrecon/core/parallel.h>

namespace gpsrecon::internal {
namespace {

/// The points of component s are point[offset[s] .. offset[s + 1]), ascending.
struct Members {
  std::vector<std::size_t> offset;
  std::vector<WeightedPoint> point;

  Members(const PointCloud& cloud, std::span<const Index> component_of, std::size_t components)
      : offset(components + 1, 0), point(component_of.size()) {
    for (const Index s : component_of) ++offset[s + 1];
    for (std::size_t s = 0; s < components; ++s) offset[s + 1] += offset[s];
    std::vector<std::size_t> next(offset.begin(), offset.end() - 1);
    for (std::size_t i = 0; i < component_of.size(); ++i)
      point[next[component_of[i]]++] = {static_cast<Index>(i), cloud.weight(i)};
  }
  std::span<const WeightedPoint> operator[](std::size_t s) const {
    return {point.data() + offset[s], point.data() + offset[s + 1]};
  }
};

}  // namespace

void carry_attributes(const PointCloud& cloud, std::span<const Index> component_of, Mixture& mixture,
                      const RunContext& context) {
  const std::size_t n = mixture.size();
  const Members members(cloud, component_of, n);
  if (!cloud.colors.empty()) {
    mixture.colors.resize(n);
    parallel_for(n, context, [&](std::size_t s) { mixture.colors[s] = mean_color(cloud.colors, members[s]); });
  }
  for (const ScalarColumn& column : cloud.scalars) {
    ScalarColumn& carried =
        mixture.scalars.emplace_back(ScalarColumn{column.name, std::vector<double>(n), column.kind});
    parallel_for(n, context, [&](std::size_t s) { carried.values[s] = combine(column, members[s]); });
  }
}

}  // namespace gpsrecon::internal
