// Files that were cut off or changed: an InputError or a result, never anything else.

#include <gpsrecon/core/error.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>

#include "small_files.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::TemporaryFolder;
using test::write_bytes;

// True if it was read, false if it was refused.
bool survives(const std::function<void()>& read) {
  try {
    read();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

class SmallFile : public testing::TestWithParam<std::pair<std::string, std::string>> {
 protected:
  const std::string& name() const { return GetParam().first; }
  const std::string& bytes() const { return GetParam().second; }
  bool is_pcd() const { return name().ends_with(".pcd"); }

  void read_as_what_it_is(const std::string& path) const {
    if (name().starts_with("mixture"))
      read_mixture(path);
    else if (name().starts_with("covmesh"))
      read_covmesh(path);
    else if (name().starts_with("mesh") || name().ends_with(".stl"))
      read_mesh(path);
    else
      read_points(path);
  }
};

TEST_P(SmallFile, CutAnywhereIsAnErrorUnlessNothingIsMissing) {
#ifndef GPSRECON_HAS_PCD
  if (is_pcd()) GTEST_SKIP() << "built without PCL";
#endif
  const TemporaryFolder folder;
  const std::string path = folder / name();
  write_bytes(path, bytes());
  ASSERT_NO_THROW(read_as_what_it_is(path));

  const bool is_text = bytes().find('\0') == std::string::npos;
  std::size_t needed = bytes().size();
  if (is_text) {
    // The final end of line is not needed; whether the digits before it are complete cannot be told.
    while (bytes()[needed - 1] == '\n') --needed;
    while (needed > 0 && bytes()[needed - 1] != ' ' && bytes()[needed - 1] != ';' && bytes()[needed - 1] != '\n')
      --needed;
  }
  const bool rows_are_not_counted = name().ends_with(".xyz") || name().ends_with(".csv") || name().ends_with(".obj");
  for (std::size_t size = 0; size < bytes().size(); ++size) {
    write_bytes(path, bytes().substr(0, size));
    const bool read = survives([&] { read_as_what_it_is(path); });
    if (size < needed && !rows_are_not_counted) {
      EXPECT_FALSE(read) << "cut after " << size << " of " << bytes().size();
    }
    if (is_text && size + 1 == bytes().size()) {
      EXPECT_TRUE(read) << "without the last end of line";
    }
  }
}

TEST_P(SmallFile, ChangedAnywhereIsAnErrorOrAResult) {
#ifndef GPSRECON_HAS_PCD
  if (is_pcd()) GTEST_SKIP() << "built without PCL";
#endif
  const TemporaryFolder folder;
  const std::string path = folder / name();
  const char* const wanted = std::getenv("GPSRECON_FUZZ_ROUNDS");  // more of the same, for a long run by hand
  const std::uint64_t rounds = wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 600;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    std::string damaged = bytes();
    const std::uint64_t changes = 1 + random_bits(round, 0, 0) % 4;
    for (std::uint64_t change = 1; change <= changes; ++change) {
      const std::size_t at = random_bits(round, change, 0) % damaged.size();
      const std::uint64_t choice = random_bits(round, change, 1);
      const char byte = static_cast<char>(random_bits(round, change, 2));
      const char digit = "0123456789-+.eE \n,;/"[random_bits(round, change, 3) % 20];
      switch (choice % 5) {
        case 0:
          damaged[at] = byte;
          break;
        case 1:
          damaged[at] = digit;
          break;
        case 2:
          damaged.insert(at, 1, digit);
          break;
        case 3:
          damaged.erase(at, 1 + choice / 8 % 3);
          break;
        default:
          damaged[at] = static_cast<char>(damaged[at] ^ (1 << choice / 8 % 8));
          break;
      }
      if (damaged.empty()) damaged = "\n";
    }
    write_bytes(path, damaged);
    SCOPED_TRACE("round " + std::to_string(round));
    EXPECT_NO_THROW(survives([&] { probe_file(path); }));
    EXPECT_NO_THROW(survives([&] { read_points(path); }));
    if (is_pcd()) continue;
    EXPECT_NO_THROW(survives([&] { read_mesh(path); }));
    EXPECT_NO_THROW(survives([&] { read_mixture(path); }));
    EXPECT_NO_THROW(survives([&] { read_covmesh(path); }));
  }
}

INSTANTIATE_TEST_SUITE_P(EveryFormat, SmallFile, testing::ValuesIn(test::small_files()), [](const auto& test_case) {
  std::string name = test_case.param.first;
  for (char& c : name)
    if (c == '.') c = '_';
  return name;
});

}  // namespace
}  // namespace gpsrecon
