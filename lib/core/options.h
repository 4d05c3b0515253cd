#pragma once

#include <gpsrecon/core/length.h>
#include <gpsrecon/core/vec.h>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

// Every options struct describes its options once, in a table beside its members:
//
//   struct HemOptions {
//     double alpha = 2;
//     ...
//     static OptionTable fields() {
//       return {field<&HemOptions::alpha>("alpha", "(0, 10]", "how unlike Gaussians may be that merge: ..."), ...};
//     }
//     void check() const { check_fields(*this); }
//   };
//
// From the table follow the checks of ranges, the options of the command line with their help, what reports say of the
// options in force, and the tables of the manual.

namespace gpsrecon {

/// Value of an option as reports hold it.
using OptionValue = std::variant<bool, std::int64_t, double, std::string>;

/// How options of a type are read and shown: `placeholder` stands for their values in the help, `read` throws
/// OptionError saying what was expected, `text` is the shortest that is read back as the same value.
template <class T>
struct OptionType;

/// A type of its own is read by a static `parse(text)` and shown by `text()`. Length is one.
template <class T>
concept TextOption = requires(const T& value, const std::string& text) {
  { T::parse(text) } -> std::same_as<T>;
  { value.text() } -> std::same_as<std::string>;
  T::placeholder;
};
template <TextOption T>
struct OptionType<T> {
  static std::string placeholder() { return T::placeholder; }
  static T read(const std::string& text) { return T::parse(text); }
  static std::string text(const T& value) { return value.text(); }
};

/// The names separated by bars.
std::string one_of(std::span<const std::string_view> names);
/// Where `text` stands in them. Throws OptionError if it does not.
std::size_t position_in(std::span<const std::string_view> names, const std::string& text);

/// An enumeration has a function `option_names(E)` beside it with the names of its values, in their order.
template <class E>
requires std::is_enum_v<E>
struct OptionType<E> {
  static std::string placeholder() { return one_of(option_names(E{})); }
  static E read(const std::string& text) { return static_cast<E>(position_in(option_names(E{}), text)); }
  static std::string text(E value) { return std::string(option_names(E{})[static_cast<std::size_t>(value)]); }
};

template <>
struct OptionType<bool> {
  static std::string placeholder() { return ""; }
  static bool read(const std::string& text);
  static std::string text(bool value) { return value ? "true" : "false"; }
};

template <>
struct OptionType<int> {
  static std::string placeholder() { return "N"; }
  static int read(const std::string& text);
  static std::string text(int value) { return std::to_string(value); }
};

template <>
struct OptionType<std::size_t> {
  static std::string placeholder() { return "N"; }
  static std::size_t read(const std::string& text);
  static std::string text(std::size_t value) { return std::to_string(value); }
};

template <>
struct OptionType<double> {
  static std::string placeholder() { return "X"; }
  static double read(const std::string& text);
  static std::string text(double value);
};

template <>
struct OptionType<Vec3> {
  static std::string placeholder() { return "X,Y,Z"; }
  static Vec3 read(const std::string& text);
  static std::string text(const Vec3& value);
};

/// The name of a file; empty: none.
template <>
struct OptionType<std::string> {
  static std::string placeholder() { return "FILE"; }
  static std::string read(const std::string& text);
  static std::string text(const std::string& value) { return value; }
};

/// Names, separated by commas.
template <>
struct OptionType<std::vector<std::string>> {
  static std::string placeholder() { return "NAME,..."; }
  static std::vector<std::string> read(const std::string& text);
  static std::string text(const std::vector<std::string>& value);
};

/// The value of an option, for checks and to show it.
struct OptionState {
  std::string text = {};
  OptionValue value = {};
  std::optional<double> number = {};  ///< what its range is about, if anything
  bool is_given = true;               ///< false for an optional without value and a length that is automatic
};

/// The row of an option. `options` is a struct of the type that the row was made for.
struct Field {
  std::string_view name;         ///< as the command line spells it, without the dashes
  std::string_view range;        ///< "[0, 8]", "(0, 1]", "> 0", ">= 4 or 0"; empty: any. Numbers are finite in any case
  std::string_view meaning;      ///< one sentence without a full stop
  std::string_view unit = {};    ///< of the number, if it has one
  std::string_view absent = {};  ///< how a value that is not given is spelled; empty if it must be
  bool is_switch = false;        ///< true or false
  bool in_library = false;       ///< only for code: the command line does not offer it
  std::string placeholder = {};
  OptionState (*state_of)(const void* options) = nullptr;
  void (*read_into)(void* options, const std::string& text) = nullptr;
  void (*clear)(void* options) = nullptr;

  Field in(std::string_view its_unit) const { return with(&Field::unit, its_unit); }
  Field or_else(std::string_view word) const { return with(&Field::absent, word); }
  Field only_in_library() const { return with(&Field::in_library, true); }

  /// The value, spelled as `absent` says where it is not given.
  OptionState state(const void* options) const;
  /// Reads it from text. Throws OptionError saying what was expected.
  void set(void* options, const std::string& text) const;
  /// Throws OptionError naming option, range and value if it is out of its range.
  void check(const void* options) const;

 private:
  template <class T>
  Field with(T Field::*member, T value) const {
    Field copy = *this;
    copy.*member = value;
    return copy;
  }
};
using OptionTable = std::vector<Field>;

namespace options_detail {

template <class T>
struct Member;
template <class Options, class T>
struct Member<T Options::*> {
  using OptionsStruct = Options;
  using Type = T;
};

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

template <class T>
OptionState state_of(const T& value) {
  if constexpr (IsOptional<T>::value) {
    return value ? state_of(*value) : OptionState{.is_given = false};
  } else {
    OptionState state{.text = OptionType<T>::text(value)};
    if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, double>)
      state.value = value;
    else if constexpr (std::is_integral_v<T>)
      state.value = static_cast<std::int64_t>(value);
    else
      state.value = state.text;
    if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) state.number = static_cast<double>(value);
    if constexpr (std::is_same_v<T, Vec3>) state.number = value.sum();  // finite if all of them are
    if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, std::vector<std::string>>)
      state.is_given = !value.empty();
    if constexpr (std::is_same_v<T, Length>) {
      state.is_given = !value.is_automatic();
      if (state.is_given) state.number = value.number();
    }
    return state;
  }
}

}  // namespace options_detail

/// The options that nothing is said about.
template <class Options>
const Options& defaults() {
  static const Options options{};
  return options;
}

/// A row for a member of any type that OptionType knows, or an optional of one.
template <auto member>
Field field(std::string_view name, std::string_view range, std::string_view meaning) {
  using Options = typename options_detail::Member<decltype(member)>::OptionsStruct;
  using T = typename options_detail::Member<decltype(member)>::Type;
  Field row{.name = name, .range = range, .meaning = meaning};
  row.state_of = [](const void* options) {
    return options_detail::state_of(static_cast<const Options*>(options)->*member);
  };
  if constexpr (options_detail::IsOptional<T>::value) {
    using Value = typename T::value_type;
    row.absent = "none";
    row.placeholder = OptionType<Value>::placeholder();
    row.clear = [](void* options) { (static_cast<Options*>(options)->*member).reset(); };
    row.read_into = [](void* options, const std::string& text) {
      static_cast<Options*>(options)->*member = OptionType<Value>::read(text);
    };
  } else {
    row.is_switch = std::is_same_v<T, bool>;
    row.placeholder = OptionType<T>::placeholder();
    row.read_into = [](void* options, const std::string& text) {
      static_cast<Options*>(options)->*member = OptionType<T>::read(text);
    };
    if (std::is_same_v<T, std::string>) row.absent = "none";
    // What has a length by default needs one.
    const bool may_be_automatic = std::is_same_v<T, Length> && !row.state_of(&defaults<Options>()).is_given;
    if (may_be_automatic || std::is_same_v<T, std::vector<std::string>>) {
      row.absent = may_be_automatic ? "auto" : "none";
      row.clear = [](void* options) { static_cast<Options*>(options)->*member = T(); };
    }
  }
  return row;
}

/// Throws OptionError naming option, range and value for the first option that is out of its range.
template <class Options>
void check_fields(const Options& options) {
  for (const Field& field : Options::fields()) field.check(&options);
}

/// The values in force by name.
template <class Options>
std::map<std::string, OptionValue> option_values(const Options& options) {
  std::map<std::string, OptionValue> values;
  for (const Field& field : Options::fields()) values[std::string(field.name)] = field.state(&options).value;
  return values;
}

}  // namespace gpsrecon
