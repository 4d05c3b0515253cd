#!/bin/sh
# Configures and builds the release preset: scripts/build.sh [-DOPTION=VALUE ...] [target ...], all targets by default.
set -eu
cd "$(dirname "$0")/.."

options=""
targets=""
for argument in "$@"; do
  case "$argument" in
    -D*) options="$options $argument" ;;
    *) targets="$targets $argument" ;;
  esac
done

# The sources that include CGAL take up to 1.5 GB each to compile, so memory bounds the number of jobs too.
cores=$(nproc)
memory_kb=$(sed -n 's/^MemAvailable: *\([0-9]*\) kB$/\1/p' /proc/meminfo)
by_memory=$((${memory_kb:-1500000} / 1500000))
jobs=$((by_memory < cores ? by_memory : cores))
[ "$jobs" -ge 1 ] || jobs=1

# shellcheck disable=SC2086
cmake --preset release $options
# shellcheck disable=SC2086
cmake --build --preset release --parallel "$jobs" ${targets:+--target $targets}
