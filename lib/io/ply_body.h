#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ply_header.h"

// Internal to lib/io: the rows of a PLY file, in any encoding.

namespace gpsrecon::internal::io {

/// Where the values of one scalar property go: that of row i to real[i * stride], or, clamped to 0..255, to
/// byte[i * stride].
struct PlySink {
  std::size_t property;
  std::size_t stride = 1;
  double* real = nullptr;
  std::uint8_t* byte = nullptr;
};

/// What is wanted of one element; what is not wanted of it is passed over.
struct PlyRequest {
  const PlyElement* element;
  std::vector<PlySink> sinks = {};
  /// Receives the entries of the list property `list` of each row in order. Returns what was expected instead, or an
  /// empty string if they are well.
  std::function<std::string(std::span<const std::int64_t>)> on_list = {};
  std::size_t list = 0;
};

/// Walks over all rows of the file. Throws InputError with the line or byte where the file is truncated or malformed.
/// Bytes behind the last row of a binary file are ignored; lines behind that of an ASCII file are an error.
void read_ply_body(const InputFile& file, const PlyHeader& header, const std::vector<PlyRequest>& requests);

}  // namespace gpsrecon::internal::io
