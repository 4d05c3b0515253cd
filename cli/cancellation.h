#pragma once

#include <atomic>

namespace gpsrecon::cli {

/// Set by the first SIGINT or SIGTERM after catch_signals(). RunContext::cancel points to it.
const std::atomic<bool>& cancel_requested();

/// From here on SIGINT and SIGTERM ask for cancellation instead of ending the process, and a closed pipe is an error
/// of the write instead of a signal.
void catch_signals();

/// While one of these lives nothing has been created yet that would have to be removed, so that a signal ends the
/// process at once with ExitCode::cancelled: reading may block for ever (a pipe nobody writes to).
class EndAtOnceOnSignal {
 public:
  /// Throws Cancelled if a signal has come already.
  EndAtOnceOnSignal();
  ~EndAtOnceOnSignal();
  EndAtOnceOnSignal(const EndAtOnceOnSignal&) = delete;
  EndAtOnceOnSignal& operator=(const EndAtOnceOnSignal&) = delete;
};

}  // namespace gpsrecon::cli
