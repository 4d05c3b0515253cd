#include <gpsrecon/core/resource_usage.h>

#include <sys/resource.h>

#include <chrono>
#include <fstream>

namespace gpsrecon {

std::uint64_t peak_memory_bytes() {
  // getrusage() starts from the size of the process that launched this one, so the kernel's own record is asked first.
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes * 1024;
  }
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
#ifdef __APPLE__
  return static_cast<std::uint64_t>(usage.ru_maxrss);
#else
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
#endif
}

double cpu_seconds() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

StageTimer::StageTimer()
    : begin_wall_(wall_seconds()), begin_cpu_(cpu_seconds()), first_wall_(begin_wall_), first_cpu_(begin_cpu_) {}

void StageTimer::start(std::string_view name) {
  stop();
  running_ = name;
  is_running_ = true;
  begin_wall_ = wall_seconds();
  begin_cpu_ = cpu_seconds();
}

void StageTimer::stop() {
  if (!is_running_) return;
  stages_.push_back({running_, wall_seconds() - begin_wall_, cpu_seconds() - begin_cpu_});
  is_running_ = false;
}

StageTime StageTimer::total() const {
  return {"total", wall_seconds() - first_wall_, cpu_seconds() - first_cpu_};
}

}  // namespace gpsrecon
