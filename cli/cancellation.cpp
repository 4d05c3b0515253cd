#include "cancellation.h"

#include <unistd.h>

#include <gpsrecon/core/error.h>
#include <csignal>
#include <string_view>

#include "exit_code.h"

namespace gpsrecon::cli {
namespace {

// A signal handler can reach nothing but static storage.
std::atomic<bool> requested{false};
std::atomic<bool> end_at_once{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_signal(int) {
  requested.store(true, std::memory_order_relaxed);
  if (!end_at_once.load(std::memory_order_relaxed)) return;
  constexpr std::string_view message = "gpsrecon: cancelled\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
  _exit(static_cast<int>(ExitCode::cancelled));
}

}  // namespace

const std::atomic<bool>& cancel_requested() {
  return requested;
}

void catch_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

EndAtOnceOnSignal::EndAtOnceOnSignal() {
  end_at_once.store(true);
  if (!requested.load()) return;
  end_at_once.store(false);
  throw Cancelled();
}

EndAtOnceOnSignal::~EndAtOnceOnSignal() {
  end_at_once.store(false);
}

}  // namespace gpsrecon::cli
