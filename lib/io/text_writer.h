#pragma once

#include <charconv>
#include <string>
#include <string_view>

#include "output_file.h"

// Internal to lib/io: numbers to text files.

namespace gpsrecon::internal::io {

/// Writes text and numbers, the latter in the shortest form that reads back as the same number.
class TextWriter {
 public:
  explicit TextWriter(const std::string& path) : file_(path) {}

  TextWriter& text(std::string_view characters) {
    file_.write(characters);
    return *this;
  }
  template <class T>
  TextWriter& number(T value, char separator = ' ') {
    char digits[40];
    char* const end = std::to_chars(digits, digits + sizeof(digits) - 1, value).ptr;
    *end = separator;
    file_.write(digits, static_cast<std::size_t>(end - digits) + 1);
    return *this;
  }
  void commit() { file_.commit(); }

 private:
  OutputFile file_;
};

}  // namespace gpsrecon::internal::io
