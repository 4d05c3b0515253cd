#pragma once

#include <cstring>
#include <vector>

namespace gpsrecon::test {

/// Whether two arrays of plain values are equal to the bit.
template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace gpsrecon::test
