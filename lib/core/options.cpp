#include <gpsrecon/core/options.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/numbers.h>
#include <algorithm>
#include <charconv>
#include <limits>
#include <stdexcept>

namespace gpsrecon {

using namespace internal;
namespace {

/// What the text of a range says.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_is_open = false, high_is_open = false;
  bool or_zero = false;

  bool contains(double x) const {
    if (or_zero && x == 0) return true;
    return (low_is_open ? x > low : x >= low) && (high_is_open ? x < high : x <= high);
  }
};

Interval parse_range(std::string_view range) {
  Interval interval;
  std::string_view rest = range;
  const auto skip = [&rest](std::string_view word) {
    const bool found = rest.starts_with(word);
    if (found) rest.remove_prefix(word.size());
    return found;
  };
  const auto number = [&rest, range] {
    double value = 0;
    const auto [stop, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error != std::errc{}) throw std::logic_error("not a range: " + std::string(range));
    rest.remove_prefix(static_cast<std::size_t>(stop - rest.data()));
    return value;
  };
  if (skip(">= ")) {
    interval.low = number();
  } else if (skip("> ")) {
    interval.low = number();
    interval.low_is_open = true;
  } else if (!rest.empty()) {
    interval.low_is_open = skip("(");
    if (!interval.low_is_open) skip("[");
    interval.low = number();
    skip(", ");
    interval.high = number();
    interval.high_is_open = skip(")");
    if (!interval.high_is_open && !skip("]")) throw std::logic_error("not a range: " + std::string(range));
  }
  interval.or_zero = skip(" or 0");
  if (!rest.empty()) throw std::logic_error("not a range: " + std::string(range));
  return interval;
}

}  // namespace

std::string one_of(std::span<const std::string_view> names) {
  std::string all;
  for (const std::string_view name : names) {
    if (!all.empty()) all += '|';
    all += name;
  }
  return all;
}

std::size_t position_in(std::span<const std::string_view> names, const std::string& text) {
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end()) throw_expected("one of " + one_of(names), text);
  return static_cast<std::size_t>(found - names.begin());
}

bool OptionType<bool>::read(const std::string& text) {
  if (text == "true" || text == "on" || text == "yes" || text == "1") return true;
  if (text == "false" || text == "off" || text == "no" || text == "0") return false;
  throw_expected("true or false", text);
}

int OptionType<int>::read(const std::string& text) {
  const std::int64_t value = parse_integer(text);
  if (value != static_cast<int>(value)) throw_expected("a smaller integer", text);
  return static_cast<int>(value);
}

std::size_t OptionType<std::size_t>::read(const std::string& text) {
  return parse_natural(text);
}

double OptionType<double>::read(const std::string& text) {
  return parse_double(text);
}

std::string OptionType<double>::text(double value) {
  return to_text(value);
}

Vec3 OptionType<Vec3>::read(const std::string& text) {
  return parse_point(text);
}

std::string OptionType<Vec3>::text(const Vec3& value) {
  return to_text(value);
}

std::string OptionType<std::string>::read(const std::string& text) {
  if (text.empty()) throw_expected("a text that is not empty", text);
  return text;
}

std::vector<std::string> OptionType<std::vector<std::string>>::read(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    names.push_back(text.substr(begin, comma - begin));
    begin = comma + 1;
  }
  return names;
}

std::string OptionType<std::vector<std::string>>::text(const std::vector<std::string>& value) {
  std::string all;
  for (const std::string& name : value) all += (all.empty() ? "" : ",") + name;
  return all;
}

OptionState Field::state(const void* options) const {
  OptionState state = state_of(options);
  if (!state.is_given && !absent.empty()) {
    state.text = absent;
    state.value = state.text;
  }
  return state;
}

void Field::set(void* options, const std::string& text) const {
  // Where the word for none is the name of a value too, what is usual is given after all.
  const bool is_name = ("|" + placeholder + "|").find("|" + text + "|") != std::string::npos;
  if (clear != nullptr && text == absent && !is_name)
    clear(options);
  else
    read_into(options, text);
}

void Field::check(const void* options) const {
  const Interval interval = parse_range(range);
  const OptionState value = state(options);
  if (!value.is_given && (clear != nullptr || range.empty())) return;
  const bool in_range =
      value.is_given && (!value.number || (std::isfinite(*value.number) && interval.contains(*value.number)));
  if (in_range) return;
  const std::string wanted = range.empty() ? "finite" : (range[0] == '>' ? "" : "in ") + std::string(range);
  throw OptionError(std::string(name) + " must be " + wanted + (unit.empty() ? "" : " " + std::string(unit)) +
                    (clear != nullptr ? " or " + std::string(absent) : "") + ", not " + value.text);
}

}  // namespace gpsrecon
