#!/bin/sh
# Installs what is missing, builds everything and runs all tests. The last line says how many passed, failed and were
# skipped (tests on external data skip where GPSRECON_DATA_DIR has none). Exit code 0 only if no test failed.
set -eu
cd "$(dirname "$0")/.."

scripts/install_packages.sh test
scripts/build.sh -DGPSRECON_BUILD_TESTS=ON

results=$PWD/build/release/test-results.xml
rm -f "$results"
status=0
ctest --test-dir build/release --parallel "$(nproc)" --output-on-failure \
  --output-junit "$results" || status=$?
[ -f "$results" ] || { echo "test.sh: ctest wrote no results" >&2; exit 1; }

# A test that could not be started did not run either, but it was not skipped: it failed.
count() { grep -c "$1" "$results" || true; }
passed=$(count '<testcase .*status="run"')
told_to_skip=$(count '<skipped message="SKIP_')
skipped=$((told_to_skip + $(count '<testcase .*status="disabled"')))
failed=$(($(count '<testcase .*status="fail"') + $(count '<testcase .*status="notrun"') - told_to_skip))
echo
echo "$passed passed, $failed failed, $skipped skipped"
[ "$passed" -gt 0 ] || status=1
[ "$failed" -eq 0 ] || status=1
exit "$status"
