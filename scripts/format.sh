#!/bin/sh
# Formats every C++ file of the project; with --check names the files that would change, and fails if there are any.
set -eu
cd "$(dirname "$0")/.."

# Versions of clang-format disagree, so one is fixed.
command -v clang-format-14 >/dev/null || { echo "format.sh: clang-format-14 is missing" >&2; exit 1; }
sources=$(find lib cli tests -name '*.h' -o -name '*.cpp' | sort)

case "${1:-}" in
  "") echo "$sources" | xargs clang-format-14 -i ;;
  --check)
    unformatted=$(for file in $sources; do clang-format-14 "$file" | cmp -s - "$file" || echo "$file"; done)
    [ -z "$unformatted" ] || { printf 'Not formatted:\n%s\n' "$unformatted" >&2; exit 1; }
    ;;
  *) echo "usage: scripts/format.sh [--check]" >&2; exit 2 ;;
esac
