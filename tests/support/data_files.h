#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace gpsrecon::test {

/// Folder of the external test data: the environment variable GPSRECON_DATA_DIR, else the one configured at build time.
inline std::filesystem::path data_dir() {
  const char* set = std::getenv("GPSRECON_DATA_DIR");
  return set != nullptr ? set : GPSRECON_DEFAULT_DATA_DIR;
}

}  // namespace gpsrecon::test

/// Skips the running test when an external data file is missing; otherwise declares `variable` with its path.
#define GPSRECON_DATA_FILE(variable, name)                                    \
  const std::filesystem::path variable = gpsrecon::test::data_dir() / (name); \
  if (!std::filesystem::exists(variable)) GTEST_SKIP() << (variable) << " is not there; set GPSRECON_DATA_DIR"
