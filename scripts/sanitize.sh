#!/bin/sh
# Builds unit tests with the address and undefined-behaviour sanitizers and runs them: scripts/sanitize.sh [program ...].
# By default those of the folders where indices and files are handled most. Fails at the first fault of a program.
set -eu
cd "$(dirname "$0")/.."

[ $# -gt 0 ] || set -- io_tests core_test gps_test triangulate_test
scripts/build.sh --preset asan -DGPSRECON_WITH_PCL=OFF "$@"

GTEST_BRIEF=1
OMP_WAIT_POLICY=passive
UBSAN_OPTIONS=print_stacktrace=1
export GTEST_BRIEF OMP_WAIT_POLICY UBSAN_OPTIONS
printf 'build/asan/bin/%s\n' "$@" | xargs -P "$(nproc)" -n 1 env
