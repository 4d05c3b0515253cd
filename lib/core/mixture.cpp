#include <gpsrecon/core/mixture.h>

#include <gpsrecon/core/error.h>
#include <utility>

namespace gpsrecon {
namespace {

[[noreturn]] void fail(std::size_t s, const std::string& what) {
  throw InvariantError("mixture: component " + std::to_string(s) + " " + what);
}

/// Calls act(from's, to's) for every array of one entry per component. The scalars must have been given their columns.
template <class Act>
void for_each_attribute(const Mixture& from, Mixture& to, const Act& act) {
  act(from.means, to.means);
  act(from.covariances, to.covariances);
  act(from.weights, to.weights);
  act(from.normals, to.normals);
  act(from.normal_variances, to.normal_variances);
  act(from.kernels, to.kernels);
  act(from.outward, to.outward);
  act(from.colors, to.colors);
  for (std::size_t c = 0; c < from.scalars.size(); ++c) act(from.scalars[c].values, to.scalars[c].values);
}

}  // namespace

void validate(const Mixture& mixture) {
  const std::size_t n = mixture.size();
  if (mixture.covariances.size() != n || mixture.weights.size() != n)
    throw InvariantError("mixture: means, covariances and weights differ in length");
  if ((!mixture.normals.empty() && mixture.normals.size() != n) ||
      mixture.normal_variances.size() != mixture.normals.size())
    throw InvariantError("mixture: normals and normal variances must be absent or one per component");
  if ((!mixture.kernels.empty() && mixture.kernels.size() != n) ||
      (!mixture.outward.empty() && mixture.outward.size() != n))
    throw InvariantError("mixture: kernels and outward directions must be absent or one per component");
  if (!mixture.colors.empty() && mixture.colors.size() != n)
    throw InvariantError("mixture: colors must be absent or one per component");
  for (const ScalarColumn& column : mixture.scalars)
    if (column.values.size() != n)
      throw InvariantError("mixture: scalar '" + column.name + "' must have one value per component");
  for (std::size_t s = 0; s < n; ++s) {
    if (!mixture.means[s].allFinite()) fail(s, "has a mean that is not finite");
    if (!mixture.covariances[s].all_finite()) fail(s, "has a covariance that is not finite");
    if (!(mixture.weights[s] > 0) || !std::isfinite(mixture.weights[s])) fail(s, "has a weight that is not positive");
    if (!mixture.kernels.empty() && !(mixture.kernels[s] >= 0 && std::isfinite(mixture.kernels[s])))
      fail(s, "has a kernel that is not a width");
    if (!mixture.outward.empty() && !mixture.outward[s].allFinite())
      fail(s, "has an outward direction that is not finite");
    const Vec3 values = eigen_decomposition(mixture.covariances[s]).values;
    // Half the bound: the eigenvalues of a matrix on the bound are only good to a few ulp of the largest.
    if (!(values[2] > 0) || values[0] < 0.5 * min_eigenvalue_ratio * values[2])
      fail(s, "has a covariance that is not positive definite");
    if (!mixture.normals.empty() &&
        !(std::abs(mixture.normals[s].norm() - 1) < 1e-6 && mixture.normal_variances[s] >= 0))
      fail(s, "has a normal that is not a unit vector or a negative normal variance");
  }
}

Mixture select(const Mixture& mixture, const std::vector<Index>& keep) {
  Mixture kept;
  kept.sigma0 = mixture.sigma0;
  kept.spacing = mixture.spacing;
  kept.frame = mixture.frame;
  for (const ScalarColumn& column : mixture.scalars) kept.scalars.push_back({column.name, {}, column.kind});
  for_each_attribute(mixture, kept, [&keep](const auto& from, auto& to) {
    if (from.empty()) return;
    to.reserve(keep.size());
    for (const Index i : keep) to.push_back(from[i]);
  });
  return kept;
}

Index append_copy(Mixture& mixture, Index s) {
  const auto copy = static_cast<Index>(mixture.size());
  for_each_attribute(mixture, mixture, [s](const auto& from, auto& to) {
    if (from.empty()) return;
    auto value = from[s];  // push_back may move what it refers to
    to.push_back(std::move(value));
  });
  return copy;
}

}  // namespace gpsrecon
