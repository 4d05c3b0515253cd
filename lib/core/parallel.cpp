#include <omp.h>

#include <gpsrecon/core/parallel.h>
#include <atomic>
#include <exception>
#include <mutex>

namespace gpsrecon {

int RunContext::thread_count() const {
  return threads > 0 ? threads : std::max(1, omp_get_num_procs());
}

void parallel_blocks(std::size_t n, const RunContext& context,
                     const std::function<void(std::size_t, std::size_t, std::size_t)>& body, std::size_t block_size) {
  context.throw_if_cancelled();
  if (n == 0) return;
  const std::size_t blocks = (n + block_size - 1) / block_size;
  std::mutex guard;
  std::exception_ptr first_error;
  std::size_t first_error_block = blocks;
  std::atomic<bool> stop{false};
  const auto run_block = [&](std::size_t block) {
    if (stop.load(std::memory_order_relaxed)) return;
    try {
      context.throw_if_cancelled();
      body(block, block * block_size, std::min(n, (block + 1) * block_size));
    } catch (...) {
      const std::scoped_lock lock(guard);
      if (block < first_error_block) {
        first_error_block = block;
        first_error = std::current_exception();
      }
      stop.store(true, std::memory_order_relaxed);
    }
  };
  const int threads = static_cast<int>(std::min<std::size_t>(blocks, static_cast<std::size_t>(context.thread_count())));
  if (threads == 1) {
    for (std::size_t block = 0; block < blocks; ++block) run_block(block);
  } else {
    const auto count = static_cast<std::int64_t>(blocks);
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (std::int64_t block = 0; block < count; ++block) run_block(static_cast<std::size_t>(block));
  }
  if (first_error) std::rethrow_exception(first_error);
}

}  // namespace gpsrecon
