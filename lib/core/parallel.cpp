#include <gpsrecon/core/parallel.h>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>
#if defined(__linux__)
#include <sched.h>
#endif

namespace gpsrecon {
namespace {

/// Whether this thread is at work on a loop: loops within run in it alone.
thread_local bool in_loop = false;

/// Threads that help one calling thread with its loops and sleep in between. They do not spin: where other programs run
/// besides, a thread that spins keeps off the processor the one it waits for.
class Team {
 public:
  Team() = default;
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;
  ~Team() {
    {
      const std::scoped_lock lock(guard_);
      leave_ = true;
    }
    wake_.notify_all();
    for (std::thread& helper : helpers_) helper.join();
  }

  /// Calls work() here and, as soon as they are awake, in up to `helpers` other threads. Returns when all have
  /// returned; those that were not awake before work() returned here are not waited for. `work` must not throw.
  void run(std::size_t helpers, const std::function<void()>& work) {
    recruit(helpers);
    {
      const std::scoped_lock lock(guard_);
      work_ = &work;
      wanted_ = std::min(helpers, helpers_.size());
    }
    wake_.notify_all();
    in_loop = true;
    work();
    in_loop = false;
    std::unique_lock lock(guard_);
    wanted_ = 0;
    done_.wait(lock, [this] { return working_ == 0; });
  }

 private:
  void recruit(std::size_t helpers) {
    try {
      while (helpers_.size() < helpers) helpers_.emplace_back([this] { serve(); });
    } catch (const std::system_error&) {
      // The system gives no more threads: fewer do the work, with the same result.
    }
  }
  void serve() {
    in_loop = true;
    std::unique_lock lock(guard_);
    for (;;) {
      wake_.wait(lock, [this] { return leave_ || wanted_ > 0; });
      if (leave_) return;
      --wanted_;
      ++working_;
      const std::function<void()>& work = *work_;
      lock.unlock();
      work();
      lock.lock();
      if (--working_ == 0) done_.notify_one();
    }
  }

  std::mutex guard_;
  std::condition_variable wake_, done_;
  const std::function<void()>* work_ = nullptr;
  std::size_t wanted_ = 0, working_ = 0;
  bool leave_ = false;
  std::vector<std::thread> helpers_;
};

/// The team of the calling thread, which ends with it.
Team& team() {
  thread_local Team mine;
  return mine;
}

/// Processors this program may use.
int processors() {
#if defined(__linux__)
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) == 0) return std::max(1, CPU_COUNT(&allowed));
#endif
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

int RunContext::thread_count() const {
  return threads > 0 ? threads : processors();
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
  std::atomic<std::size_t> next{0};
  const std::function<void()> run_blocks = [&] {
    for (std::size_t block; (block = next.fetch_add(1, std::memory_order_relaxed)) < blocks;) {
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
    }
  };
  const std::size_t threads = std::min(blocks, static_cast<std::size_t>(context.thread_count()));
  if (threads == 1 || in_loop) {
    run_blocks();
  } else {
    team().run(threads - 1, run_blocks);
  }
  if (first_error) std::rethrow_exception(first_error);
}

}  // namespace gpsrecon
