#!/bin/sh
# Runs clang-tidy with the configuration in the root; all findings are errors.
#
#   scripts/tidy.sh [pattern ...]        every source file, or those that match the regular expressions
#   scripts/tidy.sh --changed [SECONDS]  sources changed since the branch left origin/main, or else in the last ten commits,
#                                        newest first, for at most so long (300 by default); says what was left
set -eu
cd "$(dirname "$0")/.."

command -v run-clang-tidy-14 >/dev/null || { echo "tidy.sh: run-clang-tidy-14 is missing" >&2; exit 1; }
cmake --preset release >/dev/null
database=build/release/compile_commands.json
if [ "${1:-}" != --changed ]; then
  exec run-clang-tidy-14 -quiet -p build/release -j "$(nproc)" "$@"
fi
seconds=${2:-300}

head=$(git rev-parse HEAD)
base=$(git merge-base HEAD origin/main 2>/dev/null || true)
if [ -z "$base" ] || [ "$base" = "$head" ]; then
  base=$(git rev-parse --quiet --verify HEAD~10 || git rev-list --max-parents=0 HEAD | tail -n 1)
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# A changed header is checked with the source of its name, or the first that includes it.
{ git diff --name-only HEAD; git log --name-only --format= "$base..HEAD"; } | awk '!seen[$0]++' |
  while read -r file; do
    case "$file" in
      *.cpp) echo "$file" ;;
      *.h) if [ -f "${file%.h}.cpp" ]; then echo "${file%.h}.cpp"
           else git grep -l "include.*[/\"]${file##*/}[>\"]" -- '*.cpp' | head -n 1; fi ;;
    esac
  done | awk '!seen[$0]++' |
  while read -r file; do
    if grep -q "\"file\": \"$PWD/$file\"" "$database"; then echo "$file"; fi
  done >"$folder/sources"

# shellcheck disable=SC2016
timeout "$seconds" xargs -P "$(nproc)" -n 1 sh -c '
  clang-tidy-14 --quiet -p build/release "$1" 2>/dev/null || echo "$1" >>"$0/failed"
  echo "$1" >>"$0/checked"' "$folder" <"$folder/sources" || [ $? -eq 124 ]
touch "$folder/failed" "$folder/checked"
echo "clang-tidy: $(wc -l <"$folder/checked") of $(wc -l <"$folder/sources") changed sources checked," \
  "$(wc -l <"$folder/failed") with findings"
grep -vxFf "$folder/checked" "$folder/sources" | sed 's/^/  not reached: /' || true
[ ! -s "$folder/failed" ]
