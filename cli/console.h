#pragma once

#include <gpsrecon/core/run_context.h>
#include <memory>
#include <string>
#include <vector>

#include "arguments.h"

namespace gpsrecon::cli {

/// What the program tells while it runs: messages and the progress bar, on standard error and into the log file.
/// Standard output is left to the data.
class Console {
 public:
  /// Throws OutputError if the log file cannot be written.
  explicit Console(const GlobalOptions& options);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// Threads and seed as asked for, cancelled by signals, messages and progress to this console (which must outlive
  /// it), which also keeps the record: warnings so far, its own included, and times since it was made.
  RunContext context() const;

  void info(const std::string& message) const;
  void warn(const std::string& message) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gpsrecon::cli
