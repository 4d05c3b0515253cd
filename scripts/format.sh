#!/bin/sh
# Formats every C++ file of the project; with --check only says which files would change, and fails if one would.
set -eu
cd "$(dirname "$0")/.."

# Versions of clang-format disagree, so one is fixed.
command -v clang-format-14 >/dev/null || { echo "format.sh: clang-format-14 is missing" >&2; exit 1; }
case "${1:-}" in
  "") mode="-i" ;;
  --check) mode="--dry-run --Werror" ;;
  *) echo "usage: scripts/format.sh [--check]" >&2; exit 2 ;;
esac
# shellcheck disable=SC2086
find lib cli datasets tests -name '*.h' -print0 -o -name '*.cpp' -print0 | xargs -0 clang-format-14 $mode
