#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace gpsrecon::internal {

/// 64-bit FNV-1a (Fowler, Noll, Vo): tells files apart, is no protection against forgery.
class FileHash {
 public:
  void add(std::span<const char> bytes) {
    for (const char byte : bytes) state_ = (state_ ^ static_cast<unsigned char>(byte)) * 0x100000001B3ull;
  }
  std::uint64_t value() const { return state_; }
  /// 16 lower-case hexadecimal digits.
  std::string hex() const;

 private:
  std::uint64_t state_ = 0xCBF29CE484222325ull;
};

/// The hash of a file's bytes. O(size). Throws InputError naming the file if it cannot be read.
std::string hash_file(const std::string& path);

}  // namespace gpsrecon::internal
