#!/bin/sh
# Checks the Python and shell scripts: flake8, with the configuration in the root, and shellcheck.
set -eu
cd "$(dirname "$0")/.."

for tool in flake8 shellcheck; do
  command -v "$tool" >/dev/null || { echo "lint.sh: $tool is missing" >&2; exit 1; }
done
status=0
flake8 scripts tests datasets || status=1
shellcheck .ci/run scripts/*.sh || status=1
exit "$status"
