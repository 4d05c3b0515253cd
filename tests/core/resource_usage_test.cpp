#include <gpsrecon/core/error.h>
#include <gpsrecon/core/resource_usage.h>
#include <gpsrecon/report/file_hash.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

namespace gpsrecon::test {

using namespace internal;
namespace {

/// Works until the process has used this much more processor time.
void work(double seconds) {
  volatile double x = 0;
  for (const double end = cpu_seconds() + seconds; cpu_seconds() < end;) x = std::sqrt(x + 1);
}

TEST(StageTimer, RecordsStagesInOrder) {
  StageTimer timer;
  timer.start("first");
  work(0.03);
  timer.start("second");
  work(0.01);
  timer.stop();
  timer.stop();
  work(0.01);
  timer.start("first");
  timer.stop();
  ASSERT_EQ(timer.stages().size(), 3u);
  EXPECT_EQ(timer.stages()[0].name, "first");
  EXPECT_EQ(timer.stages()[1].name, "second");
  EXPECT_EQ(timer.stages()[2].name, "first");
  EXPECT_GE(timer.stages()[0].cpu_s, 0.03);
  EXPECT_GE(timer.stages()[1].cpu_s, 0.01);
  EXPECT_LT(timer.stages()[2].cpu_s, 0.01);
  EXPECT_GT(timer.stages()[0].wall_s, 0);
  double wall = 0, cpu = 0;
  for (const StageTime& stage : timer.stages()) wall += stage.wall_s, cpu += stage.cpu_s;
  EXPECT_LE(wall, timer.total().wall_s);
  EXPECT_GE(timer.total().cpu_s, cpu + 0.01 - 1e-6);
}

TEST(ResourceUsage, PeakMemoryCoversWhatWasTouched) {
  const std::uint64_t before = peak_memory_bytes();
  EXPECT_GT(before, 1u << 20);
  constexpr std::size_t size = 200u << 20;
  { const std::vector<char> block(size, 1); }
  const std::uint64_t after = peak_memory_bytes();
  EXPECT_GE(after, size);
  EXPECT_LE(after, before + size + (64u << 20));
}

TEST(FileHash, HasItsPublishedValues) {
  const auto hash = [](std::string_view text) {
    FileHash h;
    h.add(text);
    return h.hex();
  };
  EXPECT_EQ(hash(""), "cbf29ce484222325");
  EXPECT_EQ(hash("a"), "af63dc4c8601ec8c");
  EXPECT_EQ(hash("foobar"), "85944171f73967e8");
}

TEST(FileHash, OfAFileIsThatOfItsBytes) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "gpsrecon_file_hash_test.bin";
  std::string bytes(200001, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * i / 7);
  std::ofstream(path, std::ios::binary) << bytes;
  FileHash h;
  h.add(bytes);
  EXPECT_EQ(hash_file(path.string()), h.hex());
  std::filesystem::remove(path);
  EXPECT_THROW(hash_file(path.string()), InputError);
  EXPECT_THROW(hash_file(testing::TempDir()), InputError);
}

}  // namespace
}  // namespace gpsrecon::test
