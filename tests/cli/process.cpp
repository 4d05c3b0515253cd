#include "process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace gpsrecon::test {
namespace {

struct Pipe {
  int read_end = -1, write_end = -1;

  Pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    read_end = ends[0];
    write_end = ends[1];
  }
  ~Pipe() {
    close_read();
    close_write();
  }
  void close_read() { close_end(read_end); }
  void close_write() { close_end(write_end); }
  static void close_end(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }
};

/// Appends what can be read to `text`; closes the end at its end.
void drain(Pipe& pipe, std::string& text) {
  std::array<char, 65536> buffer;
  const ssize_t n = ::read(pipe.read_end, buffer.data(), buffer.size());
  if (n > 0)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  else
    pipe.close_read();
}

/// Puts the file in the place of a descriptor, if a name is given.
void redirect(const std::string& file, int flags, int descriptor) {
  if (file.empty()) return;
  const int opened = ::open(file.c_str(), flags | O_CLOEXEC);
  if (opened < 0 || ::dup2(opened, descriptor) < 0) ::_exit(126);
}

/// Whether nothing that was written to the pipe waits to be read.
bool is_empty(const Pipe& pipe) {
  int waiting = 0;
  if (::ioctl(pipe.write_end, FIONREAD, &waiting) != 0) throw std::runtime_error("cannot look into the pipe");
  return waiting == 0;
}

}  // namespace

std::vector<std::string> names_in(const TemporaryFolder& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
    names.push_back(entry.path().lexically_relative(folder.path()).string());
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

ProcessResult run(const std::vector<std::string>& arguments, const ProcessOptions& options) {
  Pipe in, out, err;
  std::vector<char*> argv;
  std::string program = GPSRECON_PROGRAM;
  std::vector<std::string> words = arguments;
  argv.push_back(program.data());
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::vector<std::string> variables = options.environment;

  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) {
    ::dup2(in.read_end, STDIN_FILENO);
    ::dup2(out.write_end, STDOUT_FILENO);
    ::dup2(err.write_end, STDERR_FILENO);
    redirect(options.input_file, O_RDONLY, STDIN_FILENO);
    redirect(options.output_file, O_WRONLY | O_APPEND, STDOUT_FILENO);
    std::signal(SIGPIPE, SIG_DFL);  // what is ignored here would be ignored there
    if (!options.folder.empty() && ::chdir(options.folder.c_str()) != 0) ::_exit(126);
    for (std::string& variable : variables) ::putenv(variable.data());
    ::execv(program.c_str(), argv.data());
    ::_exit(127);
  }
  in.close_read();
  out.close_write();
  err.close_write();
  if (options.output_is_closed) out.close_read();
  std::signal(SIGPIPE, SIG_IGN);

  ProcessResult result;
  const auto start = std::chrono::steady_clock::now();
  std::size_t sent = 0;
  bool interrupted =
      options.interrupt_at.empty() && !options.interrupt_when_input_is_read && options.interrupt_after_seconds < 0;
  while (out.read_end >= 0 || err.read_end >= 0) {
    if (sent == options.input.size() && !options.input_stays_open) in.close_write();
    // Negative descriptors are ignored by poll().
    const bool sending = sent < options.input.size();
    std::array<pollfd, 3> wait{
        {{out.read_end, POLLIN, 0}, {err.read_end, POLLIN, 0}, {sending ? in.write_end : -1, POLLOUT, 0}}};
    ::poll(wait.data(), wait.size(), interrupted ? -1 : 2);
    if (wait[0].revents != 0) drain(out, result.out);
    if (wait[1].revents != 0) drain(err, result.err);
    if (wait[2].revents != 0) {
      const ssize_t n =
          ::write(in.write_end, options.input.data() + sent, std::min<std::size_t>(options.input.size() - sent, 4096));
      sent = n > 0 ? sent + static_cast<std::size_t>(n) : options.input.size();
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    const bool seen = !options.interrupt_at.empty() && result.err.find(options.interrupt_at) != std::string::npos;
    const bool due = options.interrupt_after_seconds >= 0 && elapsed.count() >= options.interrupt_after_seconds;
    const bool read = options.interrupt_when_input_is_read && sent == options.input.size() && is_empty(in);
    if (!interrupted && (seen || due || read)) {
      ::kill(child, options.signal);
      interrupted = true;
    }
  }
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  result.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

}  // namespace gpsrecon::test
