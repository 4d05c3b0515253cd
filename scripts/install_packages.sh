#!/bin/sh
# Installs the Debian packages that are missing, and nothing when none is.
#
#   scripts/install_packages.sh [build|test|benchmark|docs|develop]
#
#   build      what the library and the program need (default)
#   test       and what the tests and benchmarks need
#   benchmark  and what the plots of scripts/benchmark.py need (Open3D, python3-open3d, is one more peer of it if it is there)
#   docs       what scripts/docs.sh needs, and nothing else
#   develop    and what the format and lint checks and the plots and figures of the documentation need
#
# This is the only list of packages of the project. Debian 12 or later; elsewhere, install the same libraries by hand.
set -eu

build="g++ cmake ninja-build ccache libeigen3-dev libflann-dev liblz4-dev libcgal-dev libcli11-dev libspdlog-dev
  nlohmann-json3-dev libpcl-dev"
test="libgtest-dev libgmock-dev libbenchmark-dev libopenmesh-dev libosd-dev libvalijson-dev
  python3"
benchmark="python3-matplotlib python3-meshio"
docs="python3 mkdocs mkdocs-material doxygen"
develop="git clang-format-14 clang-tidy-14 clang-14 libomp-14-dev flake8 shellcheck
  python3-numpy python3-pil python3-scipy python3-vtk9 xvfb xauth"

case "${1:-build}" in
  build) wanted="$build" ;;
  test) wanted="$build $test" ;;
  benchmark) wanted="$build $test $benchmark" ;;
  docs) wanted="$docs" ;;
  develop) wanted="$build $test $benchmark $develop" ;;
  *) echo "usage: scripts/install_packages.sh [build|test|benchmark|docs|develop]" >&2; exit 2 ;;
esac

missing=""
for package in $wanted; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" -eq 0 ]; then
  as_root=""
elif command -v sudo >/dev/null; then
  as_root="sudo"
else
  echo "install_packages.sh: these packages are missing, and neither root rights nor sudo are there:$missing" >&2
  exit 1
fi

echo "Installing$missing"
$as_root apt-get -q update
# Through env, because sudo passes no environment on.
# shellcheck disable=SC2086
$as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y --no-install-recommends install $missing </dev/null
