#include <gpsrecon/core/length.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/numbers.h>
#include <algorithm>
#include <charconv>
#include <cmath>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr const char* spelling = "auto, X% of the diagonal, Xsp (sample spacings) or X (in scene units)";

/// `text` without the ending, a number, times ten to the power `exponent`. The point is moved in the text and not by
/// arithmetic, so that 0.01% is the number 0.0001 and is printed as 0.01% again.
double scaled_number(const std::string& text, std::size_t ending, int exponent) {
  const std::string digits = text.substr(0, text.size() - ending);
  try {
    const double value = parse_double(digits);
    if (exponent == 0) return value;
    const std::size_t e = digits.find_first_of("eE");
    const std::int64_t given = e == std::string::npos ? 0 : parse_integer(digits.substr(e + 1));
    return parse_double(digits.substr(0, e) + "e" + std::to_string(given + exponent));
  } catch (const OptionError&) {
    throw_expected(spelling, text);
  }
}

/// Appends the shortest text of 100 `share`, see scaled_number().
void append_percent(double share, std::string& text) {
  char buffer[32];
  const char* const end = std::to_chars(buffer, buffer + sizeof buffer, share, std::chars_format::scientific).ptr;
  const std::string_view given(buffer, static_cast<std::size_t>(end - buffer));
  const std::size_t e = given.find('e');
  if (e == std::string_view::npos) {  // not finite
    text += given;
    return;
  }
  const int exponent = share == 0 ? 0 : std::stoi(std::string(given.substr(e + 1))) + 2;
  std::string digits;
  for (const char c : given.substr(0, e)) {
    if (c == '-') text += c;
    if (c >= '0' && c <= '9') digits += c;
  }
  const int count = static_cast<int>(digits.size());
  const int point = exponent + 1;  // digits before the decimal point
  if (exponent < -4 || exponent > 15) {
    if (count > 1) digits.insert(1, 1, '.');
    text += digits;
    text += 'e';
    text += std::to_string(exponent);
  } else if (exponent < 0) {
    text += "0.";
    text.append(static_cast<std::size_t>(-exponent - 1), '0');
    text += digits;
  } else {
    digits.resize(static_cast<std::size_t>(std::max(count, point)), '0');
    if (count > point) digits.insert(static_cast<std::size_t>(point), 1, '.');
    text += digits;
  }
}

}  // namespace

Length Length::parse(const std::string& text) {
  if (text == "auto") return {};
  if (text.ends_with('%')) return of_diagonal(scaled_number(text, 1, -2));
  if (text.ends_with("sp")) return spacings(scaled_number(text, 2, 0));
  return scene(scaled_number(text, 0, 0));
}

std::string Length::text() const {
  switch (unit_) {
    case Unit::automatic:
      break;
    case Unit::diagonal: {
      std::string text;
      append_percent(number_, text);
      return text += '%';
    }
    case Unit::spacing:
      return to_text(number_) + "sp";
    case Unit::scene:
      return to_text(number_);
  }
  return "auto";
}

double Length::resolve(const LengthScale& scale, std::string_view name, double automatic) const {
  const auto times = [&](double unit, const char* what) {
    if (unit > 0) return number_ * unit;
    throw OptionError(std::string(name) + ": " + text() + " refers to the " + what + ", which is not known here");
  };
  switch (unit_) {
    case Unit::automatic:
      break;
    case Unit::diagonal:
      return times(scale.diagonal, "diagonal");
    case Unit::spacing:
      return times(scale.spacing, "sample spacing of points");
    case Unit::scene:
      return number_ * scale.scene_to_local;
  }
  return automatic;
}

}  // namespace gpsrecon
