#!/bin/sh
# Runs clang-tidy, with the configuration in the root, over every source file or over those that match the given
# regular expressions: scripts/tidy.sh [pattern ...]
set -eu
cd "$(dirname "$0")/.."

command -v run-clang-tidy-14 >/dev/null || { echo "tidy.sh: run-clang-tidy-14 is missing" >&2; exit 1; }
cmake --preset release
run-clang-tidy-14 -quiet -p build/release -j "$(nproc)" "$@"
