#include "component_search.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace gpsrecon::internal {

ComponentSearch::ComponentSearch(const Mixture& mixture) {
  std::map<int, SizeClass> by_exponent;
  for (Index s = 0; s < mixture.size(); ++s) {
    const double deviation = std::sqrt(largest_eigenvalue(mixture.covariances[s]));
    SizeClass& c = by_exponent[std::ilogb(deviation)];
    c.components.push_back(s);
    c.largest_deviation = std::max(c.largest_deviation, deviation);
  }
  for (auto& [exponent, c] : by_exponent) {
    std::vector<Vec3> means;
    for (const Index s : c.components) means.push_back(mixture.means[s]);
    c.means = Neighbors(means);
    classes_.push_back(std::move(c));
  }
}

void ComponentSearch::within(const Vec3& x, double reach, std::vector<Index>& found, double margin) const {
  found.clear();
  std::vector<Neighbor> near;
  for (const SizeClass& c : classes_) {
    c.means.within(x, reach * c.largest_deviation + margin, near);
    for (const Neighbor& n : near) found.push_back(c.components[n.index]);
  }
}

}  // namespace gpsrecon::internal
