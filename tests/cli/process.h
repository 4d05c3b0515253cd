#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gpsrecon::test {

/// A folder of its own for a test, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Path of a file in it.
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  /// Names of all that is in it, hidden files included, sorted.
  std::vector<std::string> list() const;

 private:
  std::filesystem::path path_;
};

struct ProcessResult {
  int exit_code = -1;  ///< -1 if a signal ended it
  int signal = 0;
  std::string out, err;
};

struct ProcessOptions {
  std::string input = {};               ///< what standard input holds
  std::string folder = {};              ///< working folder; empty: this one
  bool input_stays_open = false;        ///< standard input never ends
  bool output_is_closed = false;        ///< nobody reads standard output
  std::string interrupt_at = {};        ///< a signal is sent when this text has appeared on standard error
  double interrupt_after_seconds = -1;  ///< a signal is sent after this time, if >= 0
  int signal = 2;                       ///< SIGINT
};

/// Runs the program under test with `arguments` to its end.
ProcessResult run(const std::vector<std::string>& arguments, const ProcessOptions& options = {});

std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& content);

}  // namespace gpsrecon::test
