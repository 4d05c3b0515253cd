#!/bin/sh
# Runs clang-tidy over every source file, or those that match the regular expressions, with the configuration in the root
# and in tests; all findings are errors.
#
#   scripts/tidy.sh [pattern ...]
set -eu
cd "$(dirname "$0")/.."

command -v run-clang-tidy-14 >/dev/null || { echo "tidy.sh: run-clang-tidy-14 is missing" >&2; exit 1; }
cmake --preset release -DGPSRECON_BUILD_TESTS=ON >/dev/null
exec run-clang-tidy-14 -quiet -p build/release -j "$(nproc)" "$@"
