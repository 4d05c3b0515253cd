#pragma once

#include "arguments.h"
#include "exit_code.h"

namespace gpsrecon::cli {

// The commands. Each declares its arguments and parses them, checks options and outputs, reads, calls the library and
// writes.

ExitCode run_chain(Arguments& arguments);
ExitCode run_mixture(Arguments& arguments);
ExitCode run_normals(Arguments& arguments);
ExitCode run_project(Arguments& arguments);
ExitCode run_triangulate(Arguments& arguments);
ExitCode run_fit(Arguments& arguments);
ExitCode run_infer(Arguments& arguments);
ExitCode run_covmesh(Arguments& arguments);
ExitCode run_subdivide(Arguments& arguments);
ExitCode run_compare(Arguments& arguments);
ExitCode run_scan(Arguments& arguments);
ExitCode run_info(Arguments& arguments);

}  // namespace gpsrecon::cli
