#include "ply_body.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "text.h"

namespace gpsrecon::internal::io {
namespace {

static_assert(std::endian::native == std::endian::little || std::endian::native == std::endian::big);

template <class T, bool swap>
T load(const char* bytes) {
  T value;
  if constexpr (swap) {
    char reversed[sizeof(T)];
    std::reverse_copy(bytes, bytes + sizeof(T), reversed);
    std::memcpy(&value, reversed, sizeof(T));
  } else {
    std::memcpy(&value, bytes, sizeof(T));
  }
  return value;
}

std::uint8_t to_byte(double value) {
  return value > 0 ? static_cast<std::uint8_t>(std::lround(std::min(value, 255.0))) : std::uint8_t{0};
}

// Calls body(T{}) with the C++ type of `type`.
template <class Body>
auto with_type(PlyType type, const Body& body) {
  switch (type) {
    case PlyType::int8:
      return body(std::int8_t{});
    case PlyType::uint8:
      return body(std::uint8_t{});
    case PlyType::int16:
      return body(std::int16_t{});
    case PlyType::uint16:
      return body(std::uint16_t{});
    case PlyType::int32:
      return body(std::int32_t{});
    case PlyType::uint32:
      return body(std::uint32_t{});
    case PlyType::int64:
      return body(std::int64_t{});
    case PlyType::uint64:
      return body(std::uint64_t{});
    case PlyType::float32:
      return body(float{});
    default:
      return body(double{});
  }
}

template <class T, bool swap>
void load_column(const char* bytes, std::size_t row_size, std::size_t rows, const PlySink& sink, std::size_t first) {
  if (sink.real != nullptr) {
    double* const out = sink.real + first * sink.stride;
    for (std::size_t i = 0; i < rows; ++i)
      out[i * sink.stride] = static_cast<double>(load<T, swap>(bytes + i * row_size));
  } else {
    std::uint8_t* const out = sink.byte + first * sink.stride;
    for (std::size_t i = 0; i < rows; ++i)
      out[i * sink.stride] = to_byte(static_cast<double>(load<T, swap>(bytes + i * row_size)));
  }
}

std::string row_name(const PlyElement& element, std::size_t row) {
  return "row " + std::to_string(row) + " of element " + quote(element.name);
}

template <bool swap>
class BinaryBody {
 public:
  BinaryBody(const InputFile& file, const PlyHeader& header) : file_(file), position_(header.body_offset) {}

  void read(const PlyElement& element, const PlyRequest* request) {
    if (!element.has_lists())
      read_fixed(element, request);
    else
      read_varying(element, request);
  }
  void finish() const {}

 private:
  const char* data() const { return file_.bytes().data() + position_; }
  std::size_t remaining() const { return file_.bytes().size() - position_; }

  // Rows of equal size: columns are converted block by block, so that a block is in the cache for all its columns.
  void read_fixed(const PlyElement& element, const PlyRequest* request) {
    const std::size_t row_size = element.smallest_row();
    if (row_size == 0) return;
    if (element.count > remaining() / row_size) fail_truncated(element, remaining() / row_size);
    if (request != nullptr) {
      constexpr std::size_t block = 2048;
      std::vector<std::size_t> offsets;
      for (std::size_t offset = 0; const PlyProperty& p : element.properties) {
        offsets.push_back(offset);
        offset += size_of(p.type);
      }
      for (std::size_t first = 0; first < element.count; first += block) {
        const std::size_t rows = std::min<std::size_t>(block, element.count - first);
        for (const PlySink& sink : request->sinks)
          with_type(element.properties[sink.property].type, [&]<class T>(T) {
            load_column<T, swap>(data() + first * row_size + offsets[sink.property], row_size, rows, sink, first);
          });
      }
    }
    position_ += row_size * element.count;
  }

  void read_varying(const PlyElement& element, const PlyRequest* request) {
    std::vector<const PlySink*> sink_of(element.properties.size(), nullptr);
    if (request != nullptr)
      for (const PlySink& sink : request->sinks) sink_of[sink.property] = &sink;
    std::vector<std::int64_t> list;
    for (std::size_t row = 0; row < element.count; ++row) {
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (property.is_list) {
          const bool wanted = request != nullptr && request->on_list && request->list == p;
          read_list(element, property, row, wanted ? request : nullptr, list);
        } else {
          const std::size_t size = size_of(property.type);
          if (remaining() < size) fail_truncated(element, row);
          if (sink_of[p] != nullptr)
            with_type(property.type, [&]<class T>(T) { load_column<T, swap>(data(), size, 1, *sink_of[p], row); });
          position_ += size;
        }
      }
    }
  }

  void read_list(const PlyElement& element, const PlyProperty& property, std::size_t row, const PlyRequest* request,
                 std::vector<std::int64_t>& list) {
    const std::size_t begin = position_;
    if (remaining() < size_of(property.count_type)) fail_truncated(element, row);
    const std::int64_t count =
        with_type(property.count_type, [&]<class T>(T) { return static_cast<std::int64_t>(load<T, swap>(data())); });
    const std::size_t size = size_of(property.type);
    position_ += size_of(property.count_type);
    if (count < 0)
      file_.fail_at_byte(begin, row_name(element, row) + ": expected a list length, found " + std::to_string(count));
    if (static_cast<std::uint64_t>(count) > remaining() / size)
      file_.fail_at_byte(begin, row_name(element, row) + ": expected a list of " + std::to_string(count) +
                                    " entries, found the end of the file");
    if (request != nullptr) {
      list.resize(static_cast<std::size_t>(count));
      const bool integral = with_type(property.type, [&]<class T>(T) {
        for (std::size_t i = 0; i < list.size(); ++i) {
          const T value = load<T, swap>(data() + i * sizeof(T));
          if constexpr (std::is_floating_point_v<T>)
            if (!is_integer(value)) return false;
          list[i] = static_cast<std::int64_t>(value);  // NOLINT(bugprone-signed-char-misuse): PLY's char is a number
        }
        return true;
      });
      const std::string problem = integral ? request->on_list(list) : "expected integers";
      if (!problem.empty()) file_.fail_at_byte(begin, row_name(element, row) + ": " + problem);
    }
    position_ += size * static_cast<std::size_t>(count);
  }

  [[noreturn]] void fail_truncated(const PlyElement& element, std::size_t row) const {
    file_.fail_at_byte(file_.bytes().size(), "expected " + row_name(element, row) + " (of " +
                                                 std::to_string(element.count) + "), found the end of the file");
  }

  const InputFile& file_;
  std::size_t position_;
};

// One row per line, as the format defines it; empty lines are passed over.
class AsciiBody {
 public:
  AsciiBody(const InputFile& file, const PlyHeader& header)
      : file_(file), lines_(file.bytes().substr(header.body_offset), header.body_first_line) {}

  void read(const PlyElement& element, const PlyRequest* request) {
    if (element.properties.empty()) return;
    std::vector<const PlySink*> sink_of(element.properties.size(), nullptr);
    if (request != nullptr)
      for (const PlySink& sink : request->sinks) sink_of[sink.property] = &sink;
    std::vector<std::int64_t> list;
    for (std::size_t row = 0; row < element.count; ++row) {
      if (!lines_.next_filled())
        fail("expected " + row_name(element, row) + " (of " + std::to_string(element.count) +
             "), found the end of the file");
      FieldReader fields(lines_.line());
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        if (element.properties[p].is_list) {
          read_list(fields, element.properties[p], list);
          if (request == nullptr || !request->on_list || request->list != p) continue;
          const std::string problem = request->on_list(list);
          if (!problem.empty()) fail(row_name(element, row) + ": " + problem);
        } else {
          read_value(fields, element.properties[p], sink_of[p], row);
        }
      }
      std::string_view surplus;
      if (fields.next(surplus)) fail("expected the end of " + row_name(element, row) + ", found " + quote(surplus));
    }
  }

  void finish() {
    if (lines_.next_filled()) fail("expected the end of the file, found " + quote(lines_.line()));
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { file_.fail_at_line(lines_.number(), message); }

  std::string_view next_field(FieldReader& fields, const PlyProperty& property) const {
    std::string_view field;
    if (!fields.next(field))
      fail("expected a value of property " + quote(property.name) + ", found the end of the line");
    return field;
  }

  void read_value(FieldReader& fields, const PlyProperty& property, const PlySink* sink, std::size_t row) const {
    const std::string_view field = next_field(fields, property);
    double value;
    if (!parse_number(field, value))
      fail("expected a number for property " + quote(property.name) + ", found " + quote(field));
    if (sink == nullptr) return;
    if (sink->real != nullptr)
      sink->real[row * sink->stride] = value;
    else
      sink->byte[row * sink->stride] = to_byte(value);
  }

  void read_list(FieldReader& fields, const PlyProperty& property, std::vector<std::int64_t>& list) const {
    const std::string_view field = next_field(fields, property);
    std::int64_t count;
    if (!parse_integer(field, count) || count < 0)
      fail("expected the length of list " + quote(property.name) + ", found " + quote(field));
    list.clear();
    for (std::int64_t i = 0; i < count; ++i) {
      const std::string_view entry = next_field(fields, property);
      double value;
      if (!parse_number(entry, value) || (!is_floating(property.type) && !is_integer(value)))
        fail("expected " + std::string(is_floating(property.type) ? "a number" : "an integer") + " in list " +
             quote(property.name) + ", found " + quote(entry));
      // What is not an integer is no index either, whoever wants the list.
      list.push_back(is_integer(value) ? static_cast<std::int64_t>(value) : std::numeric_limits<std::int64_t>::min());
    }
  }

  const InputFile& file_;
  LineReader lines_;
};

template <class Body>
void read_elements(Body body, const PlyHeader& header, const std::vector<PlyRequest>& requests) {
  for (const PlyElement& element : header.elements) {
    const auto request = std::find_if(requests.begin(), requests.end(),
                                      [&element](const PlyRequest& r) { return r.element == &element; });
    body.read(element, request == requests.end() ? nullptr : &*request);
  }
  body.finish();
}

}  // namespace

void read_ply_body(const InputFile& file, const PlyHeader& header, const std::vector<PlyRequest>& requests) {
  constexpr PlyFormat native =
      std::endian::native == std::endian::little ? PlyFormat::little_endian : PlyFormat::big_endian;
  if (header.format == PlyFormat::ascii)
    read_elements(AsciiBody(file, header), header, requests);
  else if (header.format == native)
    read_elements(BinaryBody<false>(file, header), header, requests);
  else
    read_elements(BinaryBody<true>(file, header), header, requests);
}

}  // namespace gpsrecon::internal::io
