#pragma once

#include <gpsrecon/core/run_context.h>
#include <span>
#include <vector>

namespace gpsrecon {

/// What a set of numbers looks like. All zero for an empty set.
struct Statistics {
  std::size_t count = 0;  ///< how many values
  double weight = 0;      ///< sum of their weights; equals count without weights
  double mean = 0, rms = 0;
  double median = 0, p95 = 0,
         p99 = 0;  ///< quantile p: the smallest value with more than p of the weight at or below it
  double max = 0;
  std::size_t index_of_max = 0;  ///< the first of the largest values
};

/// Statistics of `values`, each counted `weights[i]` times (empty: once). The same bits for any number of threads.
/// O(n), with weights O(n log n). Throws InvariantError if a value is not finite, a weight is not positive and finite,
/// or the lengths differ.
Statistics statistics(std::span<const double> values, std::span<const double> weights = {},
                      const RunContext& context = {});

/// The statistics of all values times `factor` > 0.
Statistics scaled(Statistics statistics, double factor);

/// Counts of values between fixed limits.
struct Histogram {
  std::vector<double> edges;  ///< ascending, n of them
  std::vector<double>
      counts;  ///< n + 1 sums of weights: below the first edge, [edges[i], edges[i + 1]), from the last on
};

/// 1, 2 and 5 times the powers of ten from 1e-6 to 1e-1: limits, as shares of the diagonal, that make reports
/// comparable.
std::vector<double> decade_edges();

/// Sums the weights (empty: 1 each) per bin. O(n log edges). Precondition: ascending edges, finite values.
Histogram histogram(std::span<const double> values, std::vector<double> edges, std::span<const double> weights = {});

}  // namespace gpsrecon
