#pragma once

namespace gpsrecon::cli {

/// What the program tells the shell. Part of its contract: scripts rely on these numbers.
enum class ExitCode : int {
  done = 0,
  other = 1,               ///< anything not listed below, such as lack of memory
  usage = 2,               ///< unknown option or command, value out of range, contradicting options, output = input
  input = 3,               ///< input unreadable, invalid or without a single finite point
  no_surface = 4,          ///< one or two points, all points equal or on a line
  cancelled = 5,           ///< stopped by SIGINT or SIGTERM; no output was written
  output = 6,              ///< output that cannot be written
  max_error_exceeded = 7,  ///< `compare --max-error` found a larger error
};

}  // namespace gpsrecon::cli
