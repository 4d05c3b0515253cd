#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

// Internal to lib/io: the bytes of a file, and the one way to complain about them.

namespace gpsrecon::internal::io {

/// The bytes of an input file, or its first part.
class InputFile {
 public:
  /// Reads the file in one go, or at most its first `max_bytes`; "-" is standard input, which is read whole once and
  /// then kept, so that a file can be probed before it is read. Throws InputError with the reason of the system if it
  /// cannot be read, is a directory, or is empty.
  explicit InputFile(std::string path, std::size_t max_bytes = std::numeric_limits<std::size_t>::max());

  const std::string& path() const { return path_; }
  std::string_view bytes() const { return bytes_; }
  /// Size of the whole file, also if only its first part was read.
  std::size_t file_size() const { return file_size_; }

  /// Throw InputError: "path: line N: message" and "path: byte N: message".
  [[noreturn]] void fail_at_line(std::size_t line, const std::string& message) const;
  [[noreturn]] void fail_at_byte(std::size_t byte, const std::string& message) const;
  [[noreturn]] void fail(const std::string& message) const;

 private:
  std::string path_;
  std::shared_ptr<const char[]> storage_;
  std::string_view bytes_;
  std::size_t file_size_ = 0;
};

/// 'text' with quotes for a message: unprintable characters replaced, long text cut.
std::string quote(std::string_view text);

}  // namespace gpsrecon::internal::io
