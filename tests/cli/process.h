#pragma once

#include <string>
#include <vector>

#include "../support/temporary_folder.h"

namespace gpsrecon::test {

/// Names of all that is in a folder, hidden files included, sorted.
std::vector<std::string> names_in(const TemporaryFolder& folder);

/// A line split at its blanks.
std::vector<std::string> words_of(const std::string& line);

struct ProcessResult {
  int exit_code = -1;  ///< -1 if a signal ended it
  int signal = 0;
  std::string out, err;
  double cpu_seconds = 0;  ///< processor time, user and system
};

struct ProcessOptions {
  std::string input = {};                     ///< what standard input holds
  std::string input_file = {};                ///< standard input is this file instead
  std::string output_file = {};               ///< standard output is appended to this file
  std::string folder = {};                    ///< working folder; empty: this one
  std::vector<std::string> environment = {};  ///< variables: NAME=VALUE sets one, NAME alone takes it away
  bool input_stays_open = false;              ///< standard input never ends
  bool output_is_closed = false;              ///< nobody reads standard output
  std::string interrupt_at = {};              ///< a signal is sent when this text has appeared on standard error
  bool interrupt_when_input_is_read = false;  ///< a signal is sent when the program has read all of `input`
  double interrupt_after_seconds = -1;        ///< a signal is sent after this time, if >= 0
  int signal = 2;                             ///< SIGINT
};

/// Runs the program under test with `arguments` to its end.
ProcessResult run(const std::vector<std::string>& arguments, const ProcessOptions& options = {});

}  // namespace gpsrecon::test
