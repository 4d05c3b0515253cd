#include "text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>

namespace gpsrecon::internal::io {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

}  // namespace

LineReader::LineReader(std::string_view text, std::size_t first_line)
    : rest_(text), end_(text.find('\n') == std::string_view::npos ? '\r' : '\n'), number_(first_line - 1) {}

bool LineReader::next() {
  ++number_;
  if (rest_.empty()) {
    line_ = {};
    return false;
  }
  const std::size_t length = std::min(rest_.find(end_), rest_.size());
  line_ = rest_.substr(0, length);
  rest_.remove_prefix(std::min(length + 1, rest_.size()));
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  return true;
}

bool LineReader::next_filled(char comment) {
  while (next()) {
    if (comment != '\0') line_ = line_.substr(0, line_.find(comment));
    if (!std::all_of(line_.begin(), line_.end(), is_blank)) return true;
  }
  return false;
}

void FieldReader::skip_blanks() {
  std::size_t n = 0;
  while (n < rest_.size() && is_blank(rest_[n])) ++n;
  rest_.remove_prefix(n);
}

bool FieldReader::next(std::string_view& field) {
  if (rest_.empty()) return false;
  std::size_t n = 0;
  while (n < rest_.size() && !is_blank(rest_[n]) && (separator_ == ' ' || rest_[n] != separator_)) ++n;
  field = rest_.substr(0, n);
  rest_.remove_prefix(n);
  skip_blanks();
  if (separator_ != ' ' && !rest_.empty() && rest_.front() == separator_) {
    rest_.remove_prefix(1);
    skip_blanks();
  }
  return true;
}

bool parse_number(std::string_view field, double& value) {
  if (field.starts_with('+')) {  // std::from_chars knows no plus sign
    field.remove_prefix(1);
    if (field.starts_with('-')) return false;
  }
  const char* const end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (stop != end || error == std::errc::invalid_argument) return false;
  if (error == std::errc::result_out_of_range) value = std::strtod(std::string(field).c_str(), nullptr);
  return true;
}

bool is_integer(double value) {
  return std::abs(value) < 0x1p63 && std::trunc(value) == value;  // false for NaN
}

bool parse_integer(std::string_view field, std::int64_t& value) {
  const char* const end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (stop == end && error == std::errc()) return true;
  double number;
  if (!parse_number(field, number) || !is_integer(number)) return false;
  value = static_cast<std::int64_t>(number);
  return true;
}

bool same_word(std::string_view word, std::string_view lower_case) {
  return std::equal(word.begin(), word.end(), lower_case.begin(), lower_case.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

}  // namespace gpsrecon::internal::io
