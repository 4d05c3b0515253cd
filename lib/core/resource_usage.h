#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gpsrecon {

/// Largest resident memory of this process so far, in bytes; 0 where the system does not tell.
std::uint64_t peak_memory_bytes();

/// Seconds of processor time of all threads of this process so far, user and system.
double cpu_seconds();

/// Seconds of a clock that never jumps, from an arbitrary start.
double wall_seconds();

struct StageTime {
  std::string name;
  double wall_s = 0;  ///< seconds
  double cpu_s = 0;   ///< processor seconds of all threads of the process
};

/// Records how long the stages of a run take. One stage runs at a time; a stage that is started again is one more
/// entry.
class StageTimer {
 public:
  StageTimer();

  /// Ends the running stage, if any, and begins `name`.
  void start(std::string_view name);
  /// Ends the running stage, if any.
  void stop();

  /// The stages that have ended, in order.
  const std::vector<StageTime>& stages() const { return stages_; }
  /// Since construction, whatever ran.
  StageTime total() const;

 private:
  std::vector<StageTime> stages_;
  std::string running_;
  bool is_running_ = false;
  double begin_wall_, begin_cpu_;  // of the running stage
  double first_wall_, first_cpu_;  // of the timer
};

}  // namespace gpsrecon
