#!/bin/sh
# Configures and builds a preset, release by default: scripts/build.sh [--preset NAME] [-DOPTION=VALUE ...] [target ...], all
# targets by default.
set -eu
cd "$(dirname "$0")/.."

preset=release
options=""
targets=""
while [ $# -gt 0 ]; do
  case "$1" in
    --preset) preset=$2; shift ;;
    -D*) options="$options $1" ;;
    *) targets="$targets $1" ;;
  esac
  shift
done

# The sources that include CGAL take up to 1.5 GB each to compile, so memory bounds the number of jobs too.
cores=$(nproc)
memory_kb=$(sed -n 's/^MemAvailable: *\([0-9]*\) kB$/\1/p' /proc/meminfo)
by_memory=$((${memory_kb:-1500000} / 1500000))
jobs=$((by_memory < cores ? by_memory : cores))
[ "$jobs" -ge 1 ] || jobs=1

# shellcheck disable=SC2086
cmake --preset "$preset" $options
# shellcheck disable=SC2086
cmake --build --preset "$preset" --parallel "$jobs" ${targets:+--target $targets}
