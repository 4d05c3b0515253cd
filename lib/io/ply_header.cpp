#include "ply_header.h"

#include <gpsrecon/core/vec.h>
#include <algorithm>
#include <array>
#include <optional>
#include <unordered_set>

#include "text.h"

namespace gpsrecon::internal::io {
namespace {

struct TypeName {
  std::string_view name;
  PlyType type;
};

constexpr std::array<TypeName, 22> type_names{{
    {"char", PlyType::int8},      {"int8", PlyType::int8},       {"uchar", PlyType::uint8},
    {"uint8", PlyType::uint8},    {"short", PlyType::int16},     {"int16", PlyType::int16},
    {"ushort", PlyType::uint16},  {"uint16", PlyType::uint16},   {"int", PlyType::int32},
    {"int32", PlyType::int32},    {"uint", PlyType::uint32},     {"uint32", PlyType::uint32},
    {"longlong", PlyType::int64}, {"int64", PlyType::int64},     {"ulonglong", PlyType::uint64},
    {"uint64", PlyType::uint64},  {"float", PlyType::float32},   {"float32", PlyType::float32},
    {"double", PlyType::float64}, {"float64", PlyType::float64}, {"byte", PlyType::int8},
    {"ubyte", PlyType::uint8},
}};

std::optional<PlyType> type_of(std::string_view name) {
  for (const TypeName& t : type_names)
    if (t.name == name) return t.type;
  return {};
}

// Lines of a header may end with "\n", "\r\n" or "\r", whatever follows is binary; so they are cut one by one.
class HeaderLines {
 public:
  explicit HeaderLines(std::string_view bytes) : bytes_(bytes) {}

  bool next(std::string_view& line) {
    const std::size_t end = bytes_.find_first_of("\r\n", position_);
    ++number_;
    if (end == std::string_view::npos) return false;
    line = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    // In a file whose lines end with a lone "\r" a "\n" after it can only be data.
    if (bytes_[end] == '\r' && !lone_returns_) {
      if (position_ < bytes_.size() && bytes_[position_] == '\n')
        ++position_;
      else
        lone_returns_ = true;
    }
    return true;
  }
  std::size_t position() const { return position_; }
  std::size_t number() const { return number_; }

 private:
  std::string_view bytes_;
  std::size_t position_ = 0;
  std::size_t number_ = 0;
  bool lone_returns_ = false;
};

class HeaderParser {
 public:
  explicit HeaderParser(const InputFile& file) : file_(file), lines_(file.bytes()) {}

  PlyHeader parse() {
    if (!is_ply(file_)) file_.fail_at_byte(0, "expected 'ply', the first word of a PLY file");
    std::string_view line;
    lines_.next(line);
    for (bool done = false; !done;) {
      if (!lines_.next(line)) fail("expected 'end_header', found the end of the file");
      done = parse_line(line);
    }
    if (!has_format_) fail("expected a line 'format ...' before the end of the header");
    header_.body_offset = lines_.position();
    header_.body_first_line = lines_.number() + 1;
    check_counts();
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { file_.fail_at_line(lines_.number(), message); }

  bool parse_line(std::string_view line) {
    FieldReader fields(line);
    std::string_view keyword;
    if (!fields.next(keyword) || keyword == "obj_info") return false;
    if (keyword == "end_header") return true;
    if (keyword == "comment") {
      header_.comments.emplace_back(fields.rest());
      return false;
    }
    if (keyword == "format") {
      parse_format(fields);
    } else if (keyword == "element") {
      parse_element(fields);
    } else if (keyword == "property") {
      parse_property(fields);
    } else {
      fail("expected a line of a PLY header (format, comment, obj_info, element, property or end_header), found " +
           quote(line));
    }
    std::string_view surplus;
    if (fields.next(surplus)) fail("expected the end of the line, found " + quote(surplus));
    return false;
  }

  void parse_format(FieldReader& fields) {
    std::string_view name, version;
    fields.next(name);
    fields.next(version);
    if (has_format_) fail("expected one line 'format' only");
    has_format_ = true;
    if (name == "ascii")
      header_.format = PlyFormat::ascii;
    else if (name == "binary_little_endian")
      header_.format = PlyFormat::little_endian;
    else if (name == "binary_big_endian")
      header_.format = PlyFormat::big_endian;
    else
      fail("expected the format ascii, binary_little_endian or binary_big_endian, found " + quote(name));
    if (version != "1.0") fail("expected version 1.0 of the format, found " + quote(version));
  }

  void parse_element(FieldReader& fields) {
    std::string_view name, count_field;
    fields.next(name);
    fields.next(count_field);
    std::int64_t count;
    if (name.empty() || !parse_integer(count_field, count) || count < 0)
      fail("expected a name and a count that is not negative after 'element', found " + quote(count_field));
    if (header_.find(name) != nullptr) fail("expected one element of a name, found a second " + quote(name));
    header_.elements.push_back({std::string(name), static_cast<std::uint64_t>(count), {}});
    names_.clear();
  }

  void parse_property(FieldReader& fields) {
    if (header_.elements.empty()) fail("expected an 'element' before the first 'property'");
    PlyProperty property;
    std::string_view word;
    fields.next(word);
    property.is_list = word == "list";
    if (property.is_list) {
      fields.next(word);
      property.count_type = parse_type(word);
      if (is_floating(property.count_type))
        fail("expected an integer type for the length of a list, found " + quote(word));
      fields.next(word = {});
    }
    property.type = parse_type(word);
    fields.next(word = {});
    property.name = word;
    if (word.empty()) fail("expected a name of the property");
    if (!names_.insert(property.name).second)
      fail("expected one property of a name in an element, found a second " + quote(word));
    header_.elements.back().properties.push_back(std::move(property));
  }

  PlyType parse_type(std::string_view name) const {
    const std::optional<PlyType> type = type_of(name);
    if (!type) fail("expected a type (char, uchar, short, ..., float, double), found " + quote(name));
    return *type;
  }

  // No count is trusted before it is known that so many of the smallest possible rows fit into the file: in ASCII a
  // value takes at least a digit and a separator (the last one none).
  void check_counts() const {
    std::uint64_t available = file_.file_size() - header_.body_offset;
    if (header_.format == PlyFormat::ascii) ++available;
    for (const PlyElement& element : header_.elements) {
      const std::uint64_t row =
          header_.format == PlyFormat::ascii ? 2 * element.properties.size() : element.smallest_row();
      if (row > 0 && element.count > available / row)
        file_.fail_at_byte(file_.file_size(), "expected " + std::to_string(element.count) + " rows of element " +
                                                  quote(element.name) + ", found the end of the file after " +
                                                  std::to_string(file_.file_size() - header_.body_offset) +
                                                  " bytes of data");
      if (element.count >= no_index && &element == header_.vertices())
        file_.fail("expected less than 2^32 - 1 vertices, found " + std::to_string(element.count));
      available -= row * element.count;
    }
  }

  const InputFile& file_;
  HeaderLines lines_;
  PlyHeader header_;
  std::unordered_set<std::string> names_;  // of the properties of the current element
  bool has_format_ = false;
};

}  // namespace

std::size_t size_of(PlyType type) {
  constexpr std::array<std::size_t, 10> sizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

const char* name_of(PlyType type) {
  constexpr std::array<const char*, 10> names{"char", "uchar", "short",  "ushort", "int",
                                              "uint", "int64", "uint64", "float",  "double"};
  return names[static_cast<std::size_t>(type)];
}

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.is_list; });
}

std::size_t PlyElement::smallest_row() const {
  std::size_t size = 0;
  for (const PlyProperty& p : properties) size += size_of(p.is_list ? p.count_type : p.type);
  return size;
}

const PlyElement* PlyHeader::find(std::string_view name) const {
  for (const PlyElement& element : elements)
    if (element.name == name) return &element;
  return nullptr;
}

const PlyElement* PlyHeader::vertices() const {
  const PlyElement* const vertex = find("vertex");
  return vertex != nullptr ? vertex : find("component");
}

bool is_ply(const InputFile& file) {
  const std::string_view bytes = file.bytes();
  return bytes.starts_with("ply") && bytes.size() > 3 && (bytes[3] == '\n' || bytes[3] == '\r' || bytes[3] == ' ');
}

PlyHeader read_ply_header(const InputFile& file) {
  return HeaderParser(file).parse();
}

}  // namespace gpsrecon::internal::io
