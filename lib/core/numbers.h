#pragma once

#include <gpsrecon/core/vec.h>
#include <cstdint>
#include <numbers>
#include <string>

namespace gpsrecon::internal {

// Numbers as text, whatever the locale: decimal or scientific, with a point, nothing before or after.

/// The shortest text that is read back as the same number.
std::string to_text(double value);
/// The same of all three, X,Y,Z.
std::string to_text(const Vec3& value);
/// Rounded to so many significant digits, for people.
std::string number(double value, int digits = 4);
/// "1 face", "2 faces".
std::string count_of(std::size_t n, const std::string& noun);

/// Throw OptionError saying what was expected instead of `text`; numbers are finite.
double parse_double(const std::string& text);
std::int64_t parse_integer(const std::string& text);
std::uint64_t parse_natural(const std::string& text);
Vec3 parse_point(const std::string& text);

/// Throws OptionError.
[[noreturn]] void throw_expected(const std::string& what, const std::string& text);

/// Options give angles in degrees.
constexpr double radians(double degrees) {
  return degrees * (std::numbers::pi / 180);
}

}  // namespace gpsrecon::internal
