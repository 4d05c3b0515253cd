// Two sheets told apart by Otsu's threshold (Otsu 1979).

#include <gpsrecon/core/sheets.h>

#include <algorithm>
#include <numeric>

namespace gpsrecon::internal {
namespace {

/// A second sheet near by has at least this share of the points.
constexpr double least_sheet = 1.0 / 8;
/// The middle third between the centres of two sheets holds at most this share of the points. Of one sheet, noisy or
/// curved, cut in two halves, it holds a sixth or more.
constexpr double most_between = 1.0 / 24;

}  // namespace

double keep_one_sheet(std::span<const Vec3> points, const Vec3& normal, std::vector<Neighbor>& near) {
  const auto offset = [&](const Neighbor& n) { return normal.dot(points[n.index] - points[near.front().index]); };
  std::vector<double> offsets;
  offsets.reserve(near.size());
  for (const Neighbor& n : near) offsets.push_back(offset(n));
  std::sort(offsets.begin(), offsets.end());

  // The cut with the largest variance between its two sides (Otsu 1979).
  const auto n = static_cast<double>(offsets.size());
  const double sum = std::accumulate(offsets.begin(), offsets.end(), 0.0);
  double below = 0, best = 0, cut = 0, low = 0, high = 0;
  for (std::size_t k = 1; k < offsets.size(); ++k) {
    below += offsets[k - 1];
    const auto left = static_cast<double>(k), right = n - left;
    if (std::min(left, right) < least_sheet * n) continue;
    const double step = (sum - below) / right - below / left;
    if (left * right * step * step <= best) continue;
    best = left * right * step * step;
    cut = 0.5 * (offsets[k - 1] + offsets[k]);
    low = below / left;
    high = (sum - below) / right;
  }
  const double margin = (high - low) / 3;
  const auto between =
      std::count_if(offsets.begin(), offsets.end(), [&](double d) { return d > low + margin && d < high - margin; });
  if (best == 0 || static_cast<double>(between) > most_between * n) return 0;
  const bool above = cut < 0;  // where the first point is
  std::vector<Neighbor> kept;
  for (const Neighbor& other : near)
    if ((offset(other) > cut) == above) kept.push_back(other);
  near = std::move(kept);
  return high - low;
}

}  // namespace gpsrecon::internal
