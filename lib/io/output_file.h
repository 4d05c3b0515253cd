#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace gpsrecon::internal {

/// A file that is either written completely or not at all: data goes to a temporary file in the same folder, which
/// commit() renames to `path` and the destructor removes. A symbolic link is followed; the permissions of a file that
/// is replaced are kept. Devices and pipes, and "-" for standard output, are written directly.
class OutputFile {
 public:
  /// Throws OutputError with the reason of the system if a file cannot be created there, or if the file that is there
  /// is a directory or not writable.
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Throws OutputError (disk full, ...).
  void write(const void* data, std::size_t size);
  void write(std::string_view text) { write(text.data(), text.size()); }

  /// Completes the file under its own name. Call once, last. Throws OutputError.
  void commit();

 private:
  [[noreturn]] void fail(const char* action) const;

  std::string path_;       // as given, for messages
  std::string target_;     // what is replaced; empty if written directly
  std::string temporary_;  // empty if written directly, and once renamed
  std::FILE* file_ = nullptr;
};

}  // namespace gpsrecon::internal
