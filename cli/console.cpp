#include "console.h"

#include <spdlog/logger.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <mutex>

#include "cancellation.h"

namespace gpsrecon::cli {
namespace {

/// Standard error with a progress bar in its last line, which makes way for messages.
class Terminal final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit Terminal(bool shows_bar) : shows_bar_(shows_bar) {}
  ~Terminal() override { erase_bar(); }

  void draw_bar(std::string_view stage, double share) {
    if (!shows_bar_) return;
    const std::scoped_lock lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (stage == stage_ && now - drawn_ < std::chrono::milliseconds(100)) return;
    stage_ = stage;
    drawn_ = now;
    constexpr int width = 30;
    const int filled = static_cast<int>(width * std::min(1.0, std::max(0.0, share)));
    std::fprintf(stderr, "\r\033[K%-12s [%s%s] %3d %%", stage_.c_str(), std::string(filled, '#').c_str(),
                 std::string(width - filled, '.').c_str(), static_cast<int>(100 * share));
    std::fflush(stderr);
    bar_is_shown_ = true;
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    erase_bar();
    const auto size = static_cast<int>(message.payload.size());
    if (message.level == spdlog::level::warn) {
      std::fprintf(stderr, "gpsrecon: warning: %.*s\n", size, message.payload.data());
    } else {
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
      std::fprintf(stderr, "gpsrecon: [%6.2f s] %.*s\n", elapsed.count(), size, message.payload.data());
    }
  }
  void flush_() override { std::fflush(stderr); }

 private:
  void erase_bar() {
    if (bar_is_shown_) std::fputs("\r\033[K", stderr);
    bar_is_shown_ = false;
  }

  bool shows_bar_, bar_is_shown_ = false;
  std::string stage_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), drawn_;
};

std::shared_ptr<spdlog::sinks::sink> open_log_file(const std::string& path) {
  try {
    auto file = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path, true);
    file->set_level(spdlog::level::debug);
    file->set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %v");
    return file;
  } catch (const spdlog::spdlog_ex&) {
    throw OutputError(path + ": log file cannot be written");
  }
}

spdlog::level::level_enum level_of(LogLevel level) {
  switch (level) {
    case LogLevel::debug:
      return spdlog::level::debug;
    case LogLevel::info:
      return spdlog::level::info;
    case LogLevel::warning:
      break;
  }
  return spdlog::level::warn;
}

}  // namespace

struct Console::Impl {
  GlobalOptions options;
  std::shared_ptr<Terminal> terminal;
  spdlog::logger logger{"gpsrecon"};
  RunRecord record;

  void log(LogLevel level, const std::string& message) { logger.log(level_of(level), message); }
};

Console::Console(const GlobalOptions& options) : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
  const bool shows_bar = options.progress == Progress::always ||
                         (options.progress == Progress::automatic && !options.quiet && isatty(STDERR_FILENO) == 1);
  impl_->terminal = std::make_shared<Terminal>(shows_bar);
  impl_->terminal->set_level(options.quiet     ? spdlog::level::warn
                             : options.verbose ? spdlog::level::debug
                                               : spdlog::level::info);
  impl_->logger.set_level(spdlog::level::debug);
  impl_->logger.flush_on(spdlog::level::debug);
  impl_->logger.sinks().push_back(impl_->terminal);
  if (!options.log_file.empty()) impl_->logger.sinks().push_back(open_log_file(options.log_file));
}

Console::~Console() = default;

RunContext Console::context() const {
  RunContext context;
  context.threads = impl_->options.threads;
  context.seed = impl_->options.seed;
  context.cancel = &cancel_requested();
  context.record = &impl_->record;
  context.on_progress = [this](std::string_view stage, double share) { impl_->terminal->draw_bar(stage, share); };
  context.on_log = [this](LogLevel level, const std::string& message) { impl_->log(level, message); };
  return context;
}

void Console::info(const std::string& message) const {
  impl_->log(LogLevel::info, message);
}
void Console::warn(const std::string& message) const {
  context().warn(message);
}

}  // namespace gpsrecon::cli
