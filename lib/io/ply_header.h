#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "input_file.h"

// Internal to lib/io: the header of a PLY file.

namespace gpsrecon::internal::io {

enum class PlyFormat { ascii, little_endian, big_endian };

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

std::size_t size_of(PlyType type);
/// The name that headers are written with (char, uchar, ..., float, double).
const char* name_of(PlyType type);
inline bool is_floating(PlyType type) {
  return type == PlyType::float32 || type == PlyType::float64;
}

struct PlyProperty {
  std::string name;
  PlyType type;  ///< of the value, or of the entries of a list
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  ///< of a list's length
};

struct PlyElement {
  std::string name;
  std::uint64_t count;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
  /// Bytes of a row in binary files, with empty lists.
  std::size_t smallest_row() const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<std::string> comments;  ///< text after "comment ", obj_info not included
  std::vector<PlyElement> elements;
  std::size_t body_offset = 0;      ///< byte where the data begin
  std::size_t body_first_line = 1;  ///< number of the line where the data begin

  const PlyElement* find(std::string_view name) const;
  /// The element that holds points or Gaussians ("vertex", also "component"); null if there is none.
  const PlyElement* vertices() const;
};

/// True if the file begins like a PLY file.
bool is_ply(const InputFile& file);

/// Parses and checks the header. Afterwards the count of every element is small enough for its rows to fit into the
/// file, so memory may be reserved by it. Throws InputError.
PlyHeader read_ply_header(const InputFile& file);

}  // namespace gpsrecon::internal::io
