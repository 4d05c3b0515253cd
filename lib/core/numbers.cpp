#include <gpsrecon/core/numbers.h>

#include <gpsrecon/core/error.h>
#include <array>
#include <charconv>
#include <cmath>

namespace gpsrecon::internal {
namespace {

template <class T>
bool read_whole(std::string_view text, T& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && stop == text.data() + text.size();
}

}  // namespace

std::string to_text(double value) {
  std::array<char, 32> buffer{};
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

std::string to_text(const Vec3& value) {
  return to_text(value.x()) + "," + to_text(value.y()) + "," + to_text(value.z());
}

std::string number(double value, int digits) {
  std::array<char, 64> buffer{};
  char* const end = buffer.data() + buffer.size();
  return {buffer.data(), std::to_chars(buffer.data(), end, value, std::chars_format::general, digits).ptr};
}

std::string count_of(std::size_t n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
}

void throw_expected(const std::string& what, const std::string& text) {
  throw OptionError("expected " + what + ", got '" + text + "'");
}

double parse_double(const std::string& text) {
  double value = 0;
  if (!read_whole(text, value) || !std::isfinite(value)) throw_expected("a number", text);
  return value;
}

std::int64_t parse_integer(const std::string& text) {
  std::int64_t value = 0;
  if (!read_whole(text, value)) throw_expected("an integer", text);
  return value;
}

std::uint64_t parse_natural(const std::string& text) {
  std::uint64_t value = 0;
  if (!read_whole(text, value)) throw_expected("an integer >= 0", text);
  return value;
}

Vec3 parse_point(const std::string& text) {
  Vec3 point;
  std::size_t begin = 0;
  for (int i = 0; i < 3; ++i) {
    const std::size_t comma = text.find(',', begin);
    if ((comma == std::string::npos) != (i == 2)) throw_expected("three numbers X,Y,Z", text);
    if (!read_whole(std::string_view(text).substr(begin, comma - begin), point[i]) || !std::isfinite(point[i]))
      throw_expected("three numbers X,Y,Z", text);
    begin = comma + 1;
  }
  return point;
}

}  // namespace gpsrecon::internal
