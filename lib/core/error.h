#pragma once

#include <stdexcept>
#include <string>

namespace gpsrecon {

/// Base of everything the library throws on purpose. The message is one line and names what failed and why.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An option out of its range, or options that contradict each other. The message names the field and the value.
class OptionError : public Error {
 public:
  using Error::Error;
};

/// Input that cannot be read, is malformed, or holds no finite point. The message names the file, the position in it
/// (byte, line or element) and what was expected there.
class InputError : public Error {
 public:
  using Error::Error;
};

/// Valid input from which no surface can be made: one or two points, all points equal, all points on a line.
class NoSurfaceError : public Error {
 public:
  using Error::Error;
};

/// The caller asked to stop (see RunContext::cancel).
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

/// Output that cannot be written. The message names the file and the reason.
class OutputError : public Error {
 public:
  using Error::Error;
};

/// A broken invariant of a data type, found by one of the validate() functions.
class InvariantError : public Error {
 public:
  using Error::Error;
};

}  // namespace gpsrecon
