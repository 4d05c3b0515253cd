// Files appear complete or not at all.

#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>

#include "output_file.h"
#include "small_files.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::read_bytes;
using test::TemporaryFolder;
using test::write_bytes;
using testing::HasSubstr;

template <class Action>
std::string output_error_of(const Action& action) {
  try {
    action();
  } catch (const OutputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

PointCloud large_cloud() {
  PointCloud cloud;
  cloud.positions.assign(100000, Vec3(1, 2, 3));
  return cloud;
}

TEST(OutputFile, AppearsAtCommit) {
  const TemporaryFolder folder;
  const std::string path = folder / "file.txt";
  {
    OutputFile file(path);
    file.write("complete");
    EXPECT_FALSE(std::filesystem::exists(path));
    EXPECT_EQ(folder.entries(), 1u);
    file.commit();
  }
  EXPECT_EQ(read_bytes(path), "complete");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(OutputFile, LeavesTheOldFileWithoutCommit) {
  const TemporaryFolder folder;
  const std::string path = folder / "file.txt";
  write_bytes(path, "old");
  {
    OutputFile file(path);
    file.write("new");
  }
  EXPECT_EQ(read_bytes(path), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(OutputFile, TwoAtOnce) {
  const TemporaryFolder folder;
  OutputFile a(folder / "a"), b(folder / "b");
  a.write("a");
  b.write("b");
  b.commit();
  a.commit();
  EXPECT_EQ(read_bytes(folder / "a"), "a");
  EXPECT_EQ(read_bytes(folder / "b"), "b");
}

TEST(OutputFile, KeepsPermissionsAndLinks) {
  const TemporaryFolder folder;
  write_bytes(folder / "target", "old");
  ::chmod((folder / "target").c_str(), 0640);
  std::filesystem::create_symlink("target", folder / "link");
  OutputFile file(folder / "link");
  file.write("new");
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_bytes(folder / "target"), "new");
  struct stat status;
  ASSERT_EQ(::stat((folder / "target").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(OutputFile, LongNames) {
  const TemporaryFolder folder;
  const std::string longest(255, 'a'), too_long(256, 'a');
  OutputFile file(folder / longest);
  file.commit();
  EXPECT_TRUE(std::filesystem::exists(folder / longest));
  EXPECT_THAT(output_error_of([&] { OutputFile(folder / too_long); }), HasSubstr("File name too long"));
}

TEST(Writers, NameTheFileAndTheReason) {
  const TemporaryFolder folder;
  const PointCloud cloud = large_cloud();
  EXPECT_EQ(output_error_of([&] { write_points(cloud, "/dev/full"); }),
            "/dev/full: cannot write: No space left on device");
  const std::string in_missing = (folder / "missing") + "/out.ply";
  EXPECT_EQ(output_error_of([&] { write_points(cloud, in_missing); }),
            in_missing + ": cannot write: No such file or directory");
  EXPECT_EQ(output_error_of([&] { write_points(cloud, folder.path().string()); }),
            folder.path().string() + ": cannot write: Is a directory");
  for (const char* const name : {"full.ply", "full.off", "full.obj", "full.stl"}) {
    std::filesystem::create_symlink("/dev/full", folder / name);
    EXPECT_EQ(output_error_of([&] { write_mesh(test::octahedron(), folder / name); }),
              (folder / name) + ": cannot write: No space left on device");
  }
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

// A disk that fills up in the middle of a file, simulated by a limit on the size of files.
TEST(Writers, LeaveNothingBehindWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  const std::string path = folder / "out.ply";
  write_bytes(path, "old");
  rlimit before;
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 500000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = output_error_of([&] { write_points(large_cloud(), path); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(message, path + ": cannot write: File too large");
  EXPECT_EQ(read_bytes(path), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(Writers, RefuseNamesOfOtherFormats) {
  const TemporaryFolder folder;
  for (const char* const name : {"out.xyz", "out.pcd", "out.las", "out", "out.docx"})
    EXPECT_THAT(output_error_of([&] { write_mesh(test::octahedron(), folder / name); }),
                HasSubstr("expected a name with the extension .ply, .off, .obj, .stl or .glb"))
        << name;
  for (const char* const name : {"out.off", "out.stl", "out.xyz", "out.las"})
    EXPECT_THAT(output_error_of([&] { write_points({}, folder / name); }),
                HasSubstr("expected a name with the extension .ply"));
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(CheckWritable, TellsBeforehandAndLeavesNothing) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(check_writable(folder / "new.ply", true));
  EXPECT_NO_THROW(check_writable(folder / "report.json"));
  EXPECT_NO_THROW(check_writable("-", true));
  EXPECT_NO_THROW(check_writable("/dev/null"));
  EXPECT_EQ(folder.entries(), 0u);
  write_bytes(folder / "old.ply", "old");
  EXPECT_NO_THROW(check_writable(folder / "old.ply", true));
  EXPECT_EQ(read_bytes(folder / "old.ply"), "old");
  EXPECT_EQ(folder.entries(), 1u);
  EXPECT_THAT(output_error_of([&] { check_writable((folder / "missing") + "/a.ply"); }), HasSubstr("No such file"));
  EXPECT_THAT(output_error_of([&] { check_writable(folder.path().string()); }), HasSubstr("Is a directory"));
  EXPECT_THAT(output_error_of([&] { check_writable(folder.path().string() + "/"); }), HasSubstr("Is a directory"));
  EXPECT_THAT(output_error_of([&] { check_writable(""); }), HasSubstr("cannot write"));
  EXPECT_THAT(output_error_of([&] { check_writable((folder / "old.ply") + "/a.ply"); }), HasSubstr("Not a directory"));
  EXPECT_THAT(output_error_of([&] { check_writable(folder / "report.json", true); }),
              HasSubstr("expected a name with"));
}

// Standard input can be probed and then read, and standard output takes a PLY file; in a process of its own, because
// standard input is kept once it was read.
TEST(StandardStreams, ProbeReadAndWrite) {
  const TemporaryFolder folder;
  const PointCloud cloud = test::small_cloud();
  write_points(cloud, folder / "in.ply");
  const auto copy = [&] {
    if (std::freopen((folder / "in.ply").c_str(), "rb", stdin) == nullptr) std::exit(2);
    if (std::freopen((folder / "out.ply").c_str(), "wb", stdout) == nullptr) std::exit(2);
    if (probe_file("-") != FileKind::points) std::exit(3);
    write_points(read_points("-"), "-");
    std::exit(0);
  };
  EXPECT_EXIT(copy(), testing::ExitedWithCode(0), "");
  EXPECT_EQ(read_bytes(folder / "out.ply"), read_bytes(folder / "in.ply"));
}

TEST(StandardStreams, Pipe) {
  const TemporaryFolder folder;
  PointCloud cloud = large_cloud();
  write_points(cloud, folder / "in.ply");
  const auto read = [&] {
    std::FILE* const pipe = ::popen(("cat " + (folder / "in.ply")).c_str(), "r");
    if (pipe == nullptr || ::dup2(::fileno(pipe), STDIN_FILENO) < 0) std::exit(2);
    std::exit(read_points("-").size() == cloud.size() ? 0 : 3);
  };
  EXPECT_EXIT(read(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace gpsrecon
