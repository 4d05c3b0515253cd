#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "clouds.h"
#include "process.h"

namespace gpsrecon::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Cancel, while_waiting_for_standard_input) {
  for (const int signal : {SIGINT, SIGTERM}) {
    TemporaryFolder folder;
    const ProcessResult result = run({"-", "out.ply", "--dump", "levels"}, {.input = "ply\n",
                                                                            .folder = folder.path().string(),
                                                                            .input_stays_open = true,
                                                                            .interrupt_when_input_is_read = true,
                                                                            .signal = signal});
    EXPECT_EQ(result.exit_code, 5) << result.err;
    EXPECT_EQ(result.err, "gpsrecon: cancelled\n");
    EXPECT_THAT(names_in(folder), IsEmpty());
  }
}

/// Interrupts when the progress bar names a stage, so that the moment does not depend on the speed of the machine.
TEST(Cancel, in_every_stage_leaves_nothing) {
  TemporaryFolder folder;
  write_bytes(folder / "in.ply", ply_of(noisy_sphere(60000, 0.002)));
  for (const std::string stage : {"scale", "mixture", "triangulate", "fit", "subdivide"}) {
    const ProcessResult result =
        run({"in.ply", "out.ply", "--dump", "levels", "--progress", "always"},
            {.folder = folder.path().string(), .interrupt_at = stage, .signal = stage == "fit" ? SIGTERM : SIGINT});
    EXPECT_EQ(result.exit_code, 5) << stage << ": " << result.err;
    EXPECT_THAT(result.err, HasSubstr("gpsrecon: cancelled\n"));
    EXPECT_THAT(result.out, IsEmpty());
    EXPECT_THAT(names_in(folder), ElementsAre("in.ply"));
  }
}

/// The earliest signals can come before the program has begun to catch them, on a busy machine even after 20 ms: then
/// it ends as any program does, by the signal.
TEST(Cancel, at_any_time_leaves_all_or_nothing) {
  TemporaryFolder folder;
  write_bytes(folder / "in.ply", ply_of(noisy_sphere(20000, 0.002)));
  int cancelled = 0;
  for (const double time : {0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 1.0, 2.0, 4.0}) {
    const ProcessResult result =
        run({"in.ply", "out.ply"}, {.folder = folder.path().string(), .interrupt_after_seconds = time});
    if (result.exit_code == 5 || result.signal == SIGINT) {
      if (result.exit_code == 5) ++cancelled;
      EXPECT_THAT(names_in(folder), ElementsAre("in.ply"));
    } else {
      ASSERT_EQ(result.exit_code, 0) << result.err;
      EXPECT_THAT(names_in(folder), ElementsAre("in.ply", "out.covmesh.ply", "out.ply", "out.report.json"));
      break;
    }
  }
  EXPECT_GE(cancelled, 1);
}

TEST(Cancel, keeps_the_files_of_an_earlier_run) {
  TemporaryFolder folder;
  write_bytes(folder / "in.ply", ply_of(noisy_sphere(60000, 0.002)));
  write_bytes(folder / "out.ply", "earlier");
  const ProcessResult result = run({"in.ply", "out.ply", "--progress", "always"},
                                   {.folder = folder.path().string(), .interrupt_at = "triangulate"});
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_EQ(read_bytes(folder / "out.ply"), "earlier");
  EXPECT_THAT(names_in(folder), ElementsAre("in.ply", "out.ply"));
}

}  // namespace
}  // namespace gpsrecon::test
