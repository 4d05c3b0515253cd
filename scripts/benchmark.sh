#!/bin/sh
# Builds the benchmarks of the stages and runs them one after the other; arguments are passed on to each, e.g.
# scripts/benchmark.sh --benchmark_filter=Hem
set -eu
cd "$(dirname "$0")/.."

scripts/install_packages.sh test
scripts/build.sh -DGPSRECON_BUILD_BENCHMARKS=ON

# Waiting threads that spin would count as work.
OMP_WAIT_POLICY=passive
export OMP_WAIT_POLICY
found=no
for program in build/release/bin/*_bench; do
  [ -x "$program" ] || continue
  found=yes
  echo
  echo "== ${program##*/}"
  "$program" "$@"
done
[ "$found" = yes ] || { echo "benchmark.sh: no benchmark program was built" >&2; exit 1; }
