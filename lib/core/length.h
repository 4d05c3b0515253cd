#pragma once

#include <string>
#include <string_view>

namespace gpsrecon {

/// What the shares and multiples of a Length refer to. Lengths in the units of the positions; 0 = not known there.
struct LengthScale {
  double diagonal = 0;        ///< of the bounding box
  double spacing = 0;         ///< sample spacing (core/scale.h)
  double scene_to_local = 1;  ///< length, in the units of the positions, of one scene unit: 1 / Frame::scale()
};

/// A length as an option gives it, in text and in code: automatic, `0.1%` of the diagonal, `2sp`, two sample spacings,
/// or `0.2` scene units, those of the input file.
class Length {
 public:
  static constexpr const char* placeholder = "LENGTH";

  /// Automatic: whoever uses it decides.
  Length() = default;
  /// `share` 1 is the whole diagonal.
  static Length of_diagonal(double share) { return {share, Unit::diagonal}; }
  static Length spacings(double count) { return {count, Unit::spacing}; }
  static Length scene(double length) { return {length, Unit::scene}; }

  /// Reads `auto`, `X%`, `Xsp` or `X`. Throws OptionError saying what was expected.
  static Length parse(const std::string& text);
  /// The shortest text that parse() reads back as the same length.
  std::string text() const;

  bool is_automatic() const { return unit_ == Unit::automatic; }
  /// Given, and not in sample spacings: what is known of any points.
  bool needs_no_estimate() const { return unit_ == Unit::diagonal || unit_ == Unit::scene; }
  /// The number as it was given: a share, a count or a length. 0 if automatic.
  double number() const { return number_; }

  /// In the units of the positions; `automatic` if it is. Throws OptionError, naming the option `name`, if what the
  /// length refers to is not known.
  double resolve(const LengthScale& scale, std::string_view name, double automatic = 0) const;

  friend bool operator==(const Length& a, const Length& b) { return a.unit_ == b.unit_ && a.number_ == b.number_; }

 private:
  enum class Unit { automatic, diagonal, spacing, scene };
  Length(double number, Unit unit) : number_(number), unit_(unit) {}

  double number_ = 0;
  Unit unit_ = Unit::automatic;
};

}  // namespace gpsrecon
