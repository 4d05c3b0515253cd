#pragma once

#include <gpsrecon/core/run_context.h>
#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace gpsrecon::internal {

/// Indices per block of parallel_blocks and of fixed-order sums. Part of the results' definition: sums are formed per
/// block and then over blocks in order, so they do not depend on the number of threads.
inline constexpr std::size_t parallel_block_size = 4096;

/// Calls body(block, begin, end) for every block of `block_size` consecutive indices of [0, n), in threads of OpenMP;
/// in the calling one alone within a parallel region. The body must write only to slots of its own indices or block.
/// The exception of the lowest block that throws is rethrown; cancellation is checked before each block, throws
/// Cancelled.
void parallel_blocks(std::size_t n, const RunContext& context,
                     const std::function<void(std::size_t block, std::size_t begin, std::size_t end)>& body,
                     std::size_t block_size = parallel_block_size);

/// Calls body(i) for every i in [0, n), in parallel; see parallel_blocks.
template <class Body>
void parallel_for(std::size_t n, const RunContext& context, const Body& body,
                  std::size_t block_size = parallel_block_size) {
  parallel_blocks(
      n, context,
      [&body](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
      },
      block_size);
}

/// Σ term(i) over [0, n), the same bits for any number of threads. T is value-initialised and needs +=.
template <class T, class Term>
T parallel_sum(std::size_t n, const RunContext& context, const Term& term) {
  std::vector<T> partial((n + parallel_block_size - 1) / parallel_block_size, T{});
  parallel_blocks(n, context, [&](std::size_t block, std::size_t begin, std::size_t end) {
    T sum{};
    for (std::size_t i = begin; i < end; ++i) sum += term(i);
    partial[block] = sum;
  });
  T total{};
  for (const T& p : partial) total += p;
  return total;
}

}  // namespace gpsrecon::internal
