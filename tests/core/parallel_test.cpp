// Parallel loops: every index once, the same sums for any number of threads, errors and cancellation.

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/random.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>

namespace gpsrecon::test {

using namespace internal;
namespace {

RunContext with_threads(int threads) {
  RunContext context;
  context.threads = threads;
  return context;
}

TEST(ParallelFor, VisitsEveryIndexOnce) {
  for (const int threads : {1, 2, 4, 8})
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, parallel_block_size - 1, parallel_block_size,
                                parallel_block_size + 1, 5 * parallel_block_size + 3}) {
      std::vector<int> visits(n, 0);
      parallel_for(n, with_threads(threads), [&](std::size_t i) { ++visits[i]; });
      EXPECT_EQ(std::count(visits.begin(), visits.end(), 1), static_cast<std::ptrdiff_t>(n));
    }
}

TEST(ParallelBlocks, CutTheRangeInOrder) {
  std::vector<std::pair<std::size_t, std::size_t>> blocks(4);
  parallel_blocks(
      35, with_threads(3),
      [&](std::size_t b, std::size_t begin, std::size_t end) {
        blocks.at(b) = {begin, end};
      },
      10);
  EXPECT_EQ(blocks, (std::vector<std::pair<std::size_t, std::size_t>>{{0, 10}, {10, 20}, {20, 30}, {30, 35}}));
}

TEST(ParallelSum, HasTheSameBitsForAnyNumberOfThreads) {
  // Terms of very different size, so that another order gives another sum.
  const auto term = [](std::size_t i) { return std::exp(40 * random_uniform(1, 2, i) - 20); };
  constexpr std::size_t n = 100'000;
  const double one = parallel_sum<double>(n, with_threads(1), term);
  for (const int threads : {2, 4, 8})
    for (int repeat = 0; repeat < 5; ++repeat) EXPECT_EQ(parallel_sum<double>(n, with_threads(threads), term), one);
  double reversed = 0;
  for (std::size_t i = n; i-- > 0;) reversed += term(i);
  EXPECT_NE(reversed, one);
  EXPECT_NEAR(reversed, one, 1e-9 * one);
}

TEST(ParallelSum, AddsUp) {
  EXPECT_EQ(parallel_sum<std::size_t>(100'001, with_threads(4), [](std::size_t i) { return i; }), 5'000'050'000u);
  EXPECT_EQ(parallel_sum<double>(0, with_threads(4), [](std::size_t) { return 1.0; }), 0);
}

TEST(ParallelBlocks, RethrowTheErrorOfTheLowestBlock) {
  for (const int threads : {1, 2, 4, 8})
    for (int repeat = 0; repeat < 20; ++repeat) {
      // The lowest of those that fail does so late, when others have failed before it.
      try {
        parallel_blocks(
            100, with_threads(threads),
            [](std::size_t block, std::size_t, std::size_t) {
              if (block < 3) return;
              if (block == 3) std::this_thread::sleep_for(std::chrono::milliseconds(2));
              throw InputError("block " + std::to_string(block));
            },
            1);
        FAIL();
      } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "block 3");
      }
    }
}

TEST(ParallelFor, StopsAfterAnError) {
  std::atomic<std::size_t> calls{0};
  EXPECT_THROW(parallel_for(
                   1'000'000, with_threads(2),
                   [&](std::size_t) {
                     ++calls;
                     throw InputError("no");
                   },
                   10),
               InputError);
  EXPECT_LT(calls, 100u);
}

TEST(ParallelFor, IsCancelledBeforeAndWhileItRuns) {
  std::atomic<bool> cancel{true};
  for (const int threads : {1, 4}) {
    RunContext context = with_threads(threads);
    context.cancel = &cancel;
    cancel = true;
    EXPECT_THROW(parallel_for(10, context, [](std::size_t) { FAIL(); }), Cancelled);
    EXPECT_THROW(parallel_for(0, context, [](std::size_t) { FAIL(); }), Cancelled);
    cancel = false;
    std::atomic<std::size_t> calls{0};
    EXPECT_THROW(parallel_for(
                     1'000'000, context,
                     [&](std::size_t) {
                       if (++calls == 50) cancel = true;
                     },
                     1),
                 Cancelled);
    EXPECT_LT(calls, 1000u);
  }
}

TEST(RunContext, UsesAtLeastOneThread) {
  EXPECT_GE(RunContext{}.thread_count(), 1);
  EXPECT_EQ(with_threads(3).thread_count(), 3);
}

TEST(RunContext, ProgressReportsThenChecksForCancellation) {
  std::atomic<bool> cancel{false};
  std::vector<double> shares;
  RunContext context;
  context.on_progress = [&](std::string_view stage, double share) {
    EXPECT_EQ(stage, "stage");
    shares.push_back(share);
    cancel = share > 0.4;
  };
  context.cancel = &cancel;
  EXPECT_NO_THROW(context.progress("stage", 0.25));
  EXPECT_THROW(context.progress("stage", 0.5), Cancelled);
  EXPECT_EQ(shares, (std::vector<double>{0.25, 0.5}));
}

TEST(ParallelBlocks, RunInSeveralThreads) {
  const RunContext context = with_threads(3);
  std::mutex guard;
  std::set<std::thread::id> seen;
  // Every block waits for another thread to come, for as long as a test may take.
  std::condition_variable arrived;
  parallel_blocks(
      3, context,
      [&](std::size_t, std::size_t, std::size_t) {
        std::unique_lock lock(guard);
        seen.insert(std::this_thread::get_id());
        arrived.notify_all();
        EXPECT_TRUE(arrived.wait_for(lock, std::chrono::seconds(30), [&] { return seen.size() > 1; }));
      },
      1);
  EXPECT_GT(seen.size(), 1U);
  EXPECT_LE(seen.size(), 3U);
}

TEST(ParallelFor, LoopsWithinLoopsRunInOneThread) {
  omp_set_max_active_levels(2);  // as a program may that has regions within regions
  const RunContext context = with_threads(4);
  std::vector<std::vector<int>> visits(20, std::vector<int>(50, 0));
  parallel_for(
      visits.size(), context,
      [&](std::size_t i) {
        const std::thread::id outer = std::this_thread::get_id();
        parallel_for(
            50, context,
            [&](std::size_t j) {
              ++visits[i][j];
              EXPECT_EQ(std::this_thread::get_id(), outer);
            },
            1);
      },
      1);
  for (const std::vector<int>& row : visits) EXPECT_EQ(row, std::vector<int>(50, 1));
}

TEST(ParallelFor, ManyShortLoopsFromThreadsThatComeAndGo) {
  std::vector<std::thread> callers;
  std::vector<std::size_t> sums(8, 0);
  for (std::size_t c = 0; c < sums.size(); ++c)
    callers.emplace_back([c, &sums] {
      const RunContext context = with_threads(static_cast<int>(1 + c % 4));
      for (int loop = 0; loop < 500; ++loop) {
        std::vector<std::size_t> squares(37, 0);
        parallel_for(
            squares.size(), context, [&](std::size_t i) { squares[i] = i * i; }, 4);
        sums[c] += std::accumulate(squares.begin(), squares.end(), std::size_t{0});
      }
    });
  for (std::thread& caller : callers) caller.join();
  for (const std::size_t sum : sums) EXPECT_EQ(sum, 500U * 16206U);
}

TEST(ParallelFor, GoesOnAfterAnError) {
  const RunContext context = with_threads(4);
  for (int loop = 0; loop < 100; ++loop) {
    EXPECT_THROW(parallel_for(
                     40, context,
                     [](std::size_t i) {
                       if (i == 7) throw InvariantError("seven");
                     },
                     1),
                 InvariantError);
    std::vector<int> visits(40, 0);
    parallel_for(
        visits.size(), context, [&](std::size_t i) { ++visits[i]; }, 1);
    EXPECT_EQ(visits, std::vector<int>(40, 1));
  }
}

}  // namespace
}  // namespace gpsrecon::test
