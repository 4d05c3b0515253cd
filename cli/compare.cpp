#include "commands.h"

namespace gpsrecon::cli {
ExitCode run_compare(Arguments&) { return ExitCode::other; }
}  // namespace gpsrecon::cli
