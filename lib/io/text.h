#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

// Internal to lib/io: lines, fields and numbers of text files. Lines end with "\n", "\r\n", or (in files without any
// "\n") "\r".

namespace gpsrecon::internal::io {

/// Walks over the lines of a text.
class LineReader {
 public:
  explicit LineReader(std::string_view text, std::size_t first_line = 1);

  /// Moves to the next line; false at the end of the text.
  bool next();
  /// As next, but passes over lines without any field. Everything from the character `comment` on is cut off a line.
  bool next_filled(char comment = '\0');

  /// The current line without its end.
  std::string_view line() const { return line_; }
  /// Number of the current line, counted from 1; at the end of the text the number of the line that is missing.
  std::size_t number() const { return number_; }
  /// Number of bytes after the current line.
  std::size_t remaining() const { return rest_.size(); }

 private:
  std::string_view rest_;
  std::string_view line_;
  char end_;
  std::size_t number_;
};

/// Splits a line at blanks and tabs, or, if a separator is given, at single separators with blanks around them.
class FieldReader {
 public:
  explicit FieldReader(std::string_view line, char separator = ' ') : rest_(line), separator_(separator) {
    skip_blanks();
  }

  /// The next field; false at the end of the line. Fields between two separators may be empty.
  bool next(std::string_view& field);
  /// What follows the field read last, without blanks around it.
  std::string_view rest() const { return rest_; }

 private:
  void skip_blanks();

  std::string_view rest_;
  char separator_;
};

/// Reads all of `field` as a number: decimal or scientific, with or without sign, "nan" and "inf" in any case. Values
/// beyond the range of double become infinite or zero. False if it is not a number.
bool parse_number(std::string_view field, double& value);

/// Reads all of `field` as an integer (a number of any form with an integral value). False if it is not one.
bool parse_integer(std::string_view field, std::int64_t& value);

/// True if the double is an integer that std::int64_t holds.
bool is_integer(double value);

/// Compares without regard to the case of ASCII letters; `lower_case` is in lower case.
bool same_word(std::string_view word, std::string_view lower_case);

}  // namespace gpsrecon::internal::io
