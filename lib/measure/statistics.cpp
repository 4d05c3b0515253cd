#include <gpsrecon/measure/statistics.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

void check(std::span<const double> values, std::span<const double> weights) {
  if (!weights.empty() && weights.size() != values.size())
    throw InvariantError("statistics: " + std::to_string(weights.size()) + " weights for " +
                         std::to_string(values.size()) + " values");
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) throw InvariantError("statistics: value " + std::to_string(i) + " is not finite");
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (!(weights[i] > 0) || !std::isfinite(weights[i]))
      throw InvariantError("statistics: weight " + std::to_string(i) + " is not positive and finite");
}

struct Quantiles {
  double median, p95, p99;
};

Quantiles quantiles(std::vector<double> values) {
  const auto rank = [&](double p) {
    return std::min(values.size() - 1, static_cast<std::size_t>(p * static_cast<double>(values.size())));
  };
  // From the top down: each selection leaves everything smaller to its left.
  auto end = values.end();
  const auto select = [&](double p) {
    const auto position = values.begin() + static_cast<std::ptrdiff_t>(rank(p));
    if (position < end) std::nth_element(values.begin(), position, end);
    end = position;
    return *position;
  };
  const double p99 = select(0.99), p95 = select(0.95), median = select(0.5);
  return {median, p95, p99};
}

Quantiles quantiles(std::span<const double> values, std::span<const double> weights, double total) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return values[a] < values[b] || (values[a] == values[b] && a < b); });
  std::size_t next = 0;
  double below = 0;
  const auto advance = [&](double p) {
    while (next + 1 < order.size() && below + weights[order[next]] <= p * total) below += weights[order[next++]];
    return values[order[next]];
  };
  const double median = advance(0.5), p95 = advance(0.95), p99 = advance(0.99);
  return {median, p95, p99};
}

}  // namespace

Statistics statistics(std::span<const double> values, std::span<const double> weights, const RunContext& context) {
  check(values, weights);
  Statistics s;
  s.count = values.size();
  if (values.empty()) return s;

  s.index_of_max = static_cast<std::size_t>(std::max_element(values.begin(), values.end()) - values.begin());
  s.max = values[s.index_of_max];
  // Squares of the values over the largest one neither overflow nor underflow.
  const double largest = std::max(std::abs(s.max), std::abs(*std::min_element(values.begin(), values.end())));
  const double unit = largest > 0 ? largest : 1;
  struct Sums {
    double weight = 0, first = 0, second = 0;
    Sums& operator+=(const Sums& other) {
      weight += other.weight;
      first += other.first;
      second += other.second;
      return *this;
    }
  };
  const Sums sums = parallel_sum<Sums>(values.size(), context, [&](std::size_t i) {
    const double w = weights.empty() ? 1.0 : weights[i], x = values[i] / unit;
    return Sums{w, w * x, w * x * x};
  });
  s.weight = sums.weight;
  s.mean = sums.first / sums.weight * unit;
  s.rms = std::sqrt(sums.second / sums.weight) * unit;

  const bool all_once = std::all_of(weights.begin(), weights.end(), [](double w) { return w == 1; });
  const Quantiles q = all_once ? quantiles({values.begin(), values.end()}) : quantiles(values, weights, s.weight);
  s.median = q.median;
  s.p95 = q.p95;
  s.p99 = q.p99;
  return s;
}

Statistics scaled(Statistics s, double factor) {
  for (double* x : {&s.mean, &s.rms, &s.median, &s.p95, &s.p99, &s.max}) *x *= factor;
  return s;
}

std::vector<double> decade_edges() {
  return {1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1};
}

Histogram histogram(std::span<const double> values, std::vector<double> edges, std::span<const double> weights) {
  Histogram h{std::move(edges), {}};
  h.counts.assign(h.edges.size() + 1, 0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto bin = std::upper_bound(h.edges.begin(), h.edges.end(), values[i]) - h.edges.begin();
    h.counts[static_cast<std::size_t>(bin)] += weights.empty() ? 1.0 : weights[i];
  }
  return h;
}

}  // namespace gpsrecon
