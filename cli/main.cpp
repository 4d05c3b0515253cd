#include <gpsrecon/core/error.h>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "cancellation.h"
#include "commands.h"
#if defined(__GLIBC__)
#include <malloc.h>
#endif
#if defined(__linux__)
#include <unistd.h>
#endif

namespace gpsrecon::cli {
namespace {

struct Command {
  std::string_view name;
  std::string_view summary;
  ExitCode (*run)(Arguments& arguments);
};

constexpr std::array<Command, 11> commands{{
    {"mixture", "Reduces points to a Gaussian mixture.", run_mixture},
    {"normals", "Gives points robust, oriented normals.", run_normals},
    {"project", "Projects points to local medians: less noise, even spacing, fewer or more of them.", run_project},
    {"triangulate", "Connects the Gaussians of a mixture to a covariance mesh.", run_triangulate},
    {"fit", "Moves a covariance mesh so that its surface runs through the points.", run_fit},
    {"infer", "Gives an ordinary mesh covariances: a covariance mesh.", run_infer},
    {"covmesh", "Models with the covariances of a covariance mesh.", run_covmesh},
    {"subdivide", "Refines a covariance mesh to a smooth mesh.", run_subdivide},
    {"compare", "Measures how far a mesh and a reference (a mesh or points) are apart.", run_compare},
    {"scan", "Makes a virtual scan of a mesh or of an analytic shape.", run_scan},
    {"info", "Says what files hold.", run_info},
}};

std::string chain_summary() {
  std::string text =
      "Reconstructs a smooth surface from points without normals. Beside the mesh OUT it writes the covariance mesh it "
      "comes from and a report. The same stage by stage, and more (gpsrecon COMMAND --help): ";
  for (const Command& command : commands)
    text += std::string(&command == commands.data() ? "" : ", ") + std::string(command.name);
  return text + ".";
}

ExitCode fail(ExitCode code, std::string_view message) {
  std::fprintf(stderr, "gpsrecon: error: %.*s\n", static_cast<int>(message.size()), message.data());
  return code;
}

/// The one place where errors become messages and exit codes.
template <class Run>
ExitCode guarded(const std::string& command, const Run& run) {
  try {
    return run();
  } catch (const Answered&) {
    return ExitCode::done;
  } catch (const OptionError& error) {
    const std::string hint = " (see gpsrecon" + (command.empty() ? "" : " " + command) + " --help)";
    return fail(ExitCode::usage, error.what() + hint);
  } catch (const InputError& error) {
    return fail(ExitCode::input, error.what());
  } catch (const NoSurfaceError& error) {
    return fail(ExitCode::no_surface, error.what());
  } catch (const Cancelled&) {
    std::fputs("gpsrecon: cancelled\n", stderr);
    return ExitCode::cancelled;
  } catch (const OutputError& error) {
    return fail(ExitCode::output, error.what());
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::other, "out of memory");
  } catch (const std::exception& error) {
    return fail(ExitCode::other, error.what());
  }
}

/// The command is the first word after global options; anything else there is the input of the chain.
ExitCode run(std::vector<std::string> words) {
  const auto word = words.begin() + static_cast<std::ptrdiff_t>(Arguments::position_of_command(words));
  const auto command = std::find_if(commands.begin(), commands.end(),
                                    [&](const Command& c) { return word != words.end() && c.name == *word; });
  if (command == commands.end()) {
    Arguments arguments("", chain_summary(), std::move(words));
    return guarded("", [&] { return run_chain(arguments); });
  }
  words.erase(word);
  Arguments arguments(std::string(command->name), std::string(command->summary), std::move(words));
  return guarded(std::string(command->name), [&] { return command->run(arguments); });
}

/// The stages ask for large arrays and free them again, many times over. Given back to the system in between, their
/// pages would be cleared and mapped anew each time, which took a sixth of the whole run.
void keep_freed_memory() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the largest there is; arrays above it are still given back at once
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

/// Threads of OpenMP that wait spin, unless told otherwise: they keep off the processors those they wait for, and other
/// programs (docs/evidence/threads.md). The runtime takes orders only from the environment and only while it is loaded,
/// so the program starts once more, unless the user has chosen.
void let_waiting_threads_sleep(char** argv) {
#if defined(__linux__)
  for (const char* choice : {"OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "KMP_BLOCKTIME"})
    if (std::getenv(choice) != nullptr) return;
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error || ::setenv("OMP_WAIT_POLICY", "passive", 0) != 0) return;
  ::execv(program.c_str(), argv);  // returns only if that failed: the same results, with threads that spin
#endif
}

}  // namespace
}  // namespace gpsrecon::cli

int main(int argc, char** argv) {
  using namespace gpsrecon::cli;
  let_waiting_threads_sleep(argv);
  catch_signals();
  keep_freed_memory();
  return static_cast<int>(run({argv + 1, argv + argc}));
}
