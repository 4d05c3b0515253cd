#include <gpsrecon/core/parallel.h>
#include <omp.h>
#include <atomic>
#include <exception>
#include <mutex>

namespace gpsrecon {

int RunContext::thread_count() const {
  return threads > 0 ? threads : omp_get_max_threads();
}

}  // namespace gpsrecon

namespace gpsrecon::internal {

void parallel_blocks(std::size_t n, const RunContext& context,
                     const std::function<void(std::size_t, std::size_t, std::size_t)>& body, std::size_t block_size) {
  context.throw_if_cancelled();
  const std::size_t blocks = (n + block_size - 1) / block_size;

  // No exception may leave the region. Of those that came the lowest block's is kept; blocks below it still run, so
  // that it is the same one for any number of threads.
  std::mutex guard;
  std::exception_ptr error;
  std::atomic<std::size_t> failed{blocks};
  const auto run_block = [&](std::size_t block) {
    if (block > failed.load(std::memory_order_relaxed)) return;
    try {
      context.throw_if_cancelled();
      body(block, block * block_size, std::min(n, (block + 1) * block_size));
    } catch (...) {
      const std::scoped_lock lock(guard);
      if (block > failed.load(std::memory_order_relaxed)) return;
      failed.store(block, std::memory_order_relaxed);
      error = std::current_exception();
    }
  };

  const std::size_t threads = omp_in_parallel() != 0 ? 1 : static_cast<std::size_t>(context.thread_count());
  if (threads == 1 || blocks <= 1) {
    for (std::size_t block = 0; block < blocks; ++block) run_block(block);
  } else {
#pragma omp parallel for num_threads(std::min(threads, blocks)) schedule(dynamic)
    for (std::size_t block = 0; block < blocks; ++block) run_block(block);
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace gpsrecon::internal
