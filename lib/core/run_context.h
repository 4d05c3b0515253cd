#pragma once

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/resource_usage.h>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace gpsrecon {

enum class LogLevel { debug, info, warning };

/// What a run leaves behind besides its results.
struct RunRecord {
  std::vector<std::string> warnings;
  StageTimer times;
};

/// How a stage runs: threads, seed, and whom to tell. The default is silent, one seed, all threads. Results never
/// depend on `threads`.
struct RunContext {
  int threads = 0;         ///< number of threads, >= 1; 0 = OMP_NUM_THREADS, or else all of the machine
  std::uint64_t seed = 1;  ///< seed of everything random

  /// Called from the calling thread with the name of the running stage and the share done, in [0, 1].
  std::function<void(std::string_view stage, double share)> on_progress;
  /// Called from the calling thread.
  std::function<void(LogLevel level, const std::string& message)> on_log;
  /// When it becomes true the running stage throws Cancelled at its next check. May be null.
  const std::atomic<bool>* cancel = nullptr;
  /// Where warnings and the times of stages are collected. May be null; must outlive the run.
  RunRecord* record = nullptr;

  int thread_count() const;
  bool cancelled() const { return cancel != nullptr && cancel->load(std::memory_order_relaxed); }
  void throw_if_cancelled() const {
    if (cancelled()) throw Cancelled();
  }
  void progress(std::string_view stage, double share) const {
    if (on_progress) on_progress(stage, share);
    throw_if_cancelled();
  }
  void log(LogLevel level, const std::string& message) const {
    if (on_log) on_log(level, message);
  }
  void warn(const std::string& message) const {
    if (record != nullptr) record->warnings.push_back(message);
    log(LogLevel::warning, message);
  }
  /// Begins a stage, whose time is recorded.
  void begin(std::string_view stage) const {
    if (record != nullptr) record->times.start(stage);
  }
};

}  // namespace gpsrecon
