#include "ply_comment.h"

#include <gpsrecon/core/version.h>
#include <array>
#include <charconv>
#include <cmath>

#include "text.h"

namespace gpsrecon::internal::io {
namespace {

// Shortest text that reads back as the same double.
std::string exact(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

template <class T>
using Words = std::array<std::pair<std::string_view, T>, 2>;
constexpr Words<Scheme> schemes{{{"loop", Scheme::loop}, {"catmull-clark", Scheme::catmull_clark}}};
constexpr Words<LoopWeights> loop_weights{{{"loop", LoopWeights::loop}, {"warren", LoopWeights::warren}}};
constexpr Words<CornerRule> corner_rules{{{"smooth", CornerRule::smooth}, {"sharp", CornerRule::sharp}}};

template <class T>
std::string word_of(const Words<T>& words, T value) {
  return std::string(words[0].second == value ? words[0].first : words[1].first);
}

/// False if the next field is none of the words.
template <class T>
bool read_word(FieldReader& fields, const Words<T>& words, T& value) {
  std::string_view field;
  if (!fields.next(field)) return false;
  for (const auto& [word, meant] : words)
    if (word == field) return value = meant, true;
  return false;
}

/// True if the comment is one of this program about `subject`; the fields after that word are still to be read.
bool is_about(FieldReader& fields, std::string_view subject) {
  std::string_view word;
  return fields.next(word) && word == "gpsrecon" && fields.next(word) && fields.next(word) && word == subject;
}

}  // namespace

std::string version_comment() {
  return std::string("gpsrecon ") + version;
}

std::string frame_comment(const FrameComment& comment) {
  const Vec3& origin = comment.frame.origin;
  return version_comment() + " frame " + exact(origin.x()) + " " + exact(origin.y()) + " " + exact(origin.z()) + " " +
         std::to_string(comment.frame.exponent) + " sigma0 " + exact(comment.sigma0) + " spacing " +
         exact(comment.spacing);
}

std::string label_comment(const std::vector<std::string>& columns) {
  std::string comment = version_comment() + " labels";
  for (const std::string& column : columns) comment += " " + column;
  return comment;
}

std::vector<std::string> find_label_comment(const PlyHeader& header) {
  std::vector<std::string> columns;
  for (const std::string& comment : header.comments) {
    FieldReader fields(comment);
    if (!is_about(fields, "labels")) continue;
    for (std::string_view column; fields.next(column);) columns.emplace_back(column);
  }
  return columns;
}

std::string rules_comment(const SurfaceRules& rules) {
  return version_comment() + " scheme " + word_of(schemes, rules.scheme) + " weights " +
         word_of(loop_weights, rules.weights) + " corners " + word_of(corner_rules, rules.corners);
}

std::optional<SurfaceRules> find_rules_comment(const InputFile& file, const PlyHeader& header) {
  for (const std::string& comment : header.comments) {
    FieldReader fields(comment);
    if (!is_about(fields, "scheme")) continue;
    SurfaceRules rules;
    const auto subject = [&fields](std::string_view expected) {
      std::string_view word;
      return fields.next(word) && word == expected;
    };
    if (!(read_word(fields, schemes, rules.scheme) && subject("weights") &&
          read_word(fields, loop_weights, rules.weights) && subject("corners") &&
          read_word(fields, corner_rules, rules.corners)))
      file.fail(
          "expected the comment 'gpsrecon VERSION scheme loop|catmull-clark weights loop|warren corners smooth|sharp' "
          "in "
          "the header, found " +
          quote(comment));
    return rules;
  }
  return std::nullopt;
}

FrameComment find_frame_comment(const InputFile& file, const PlyHeader& header) {
  for (const std::string& comment : header.comments) {
    FieldReader fields(comment);
    if (!is_about(fields, "frame")) continue;
    std::string_view word;
    FrameComment found;
    const auto number = [&fields](double& value) {
      std::string_view field;
      return fields.next(field) && parse_number(field, value) && std::isfinite(value);
    };
    double exponent;
    constexpr int largest_exponent = 500;  // its square still scales covariances without overflow
    const bool valid = number(found.frame.origin.x()) && number(found.frame.origin.y()) &&
                       number(found.frame.origin.z()) && number(exponent) && std::trunc(exponent) == exponent &&
                       std::abs(exponent) <= largest_exponent && fields.next(word) && word == "sigma0" &&
                       number(found.sigma0) && found.sigma0 >= 0;
    if (!valid)
      file.fail(
          "expected the comment 'gpsrecon VERSION frame X Y Z EXPONENT sigma0 S spacing A' in the header, found " +
          quote(comment));
    if (fields.next(word) && word == "spacing" && !(number(found.spacing) && found.spacing >= 0))
      file.fail("expected a spacing >= 0 in the header, found " + quote(comment));
    found.frame.exponent = static_cast<int>(exponent);
    return found;
  }
  return {};
}

}  // namespace gpsrecon::internal::io
