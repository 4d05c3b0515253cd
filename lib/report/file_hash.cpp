#include <gpsrecon/report/file_hash.h>

#include <gpsrecon/core/error.h>
#include <fstream>
#include <vector>

namespace gpsrecon::internal {

std::string FileHash::hex() const {
  std::string digits(16, '0');
  for (std::size_t i = 0; i < 16; ++i) digits[i] = "0123456789abcdef"[(state_ >> (60 - 4 * i)) & 15];
  return digits;
}

std::string hash_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path + ": cannot be opened for reading");
  FileHash hash;
  std::vector<char> buffer(1 << 16);
  while (file) {
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    hash.add({buffer.data(), static_cast<std::size_t>(file.gcount())});
  }
  if (file.bad()) throw InputError(path + ": reading failed");
  return hash.hex();
}

}  // namespace gpsrecon::internal
