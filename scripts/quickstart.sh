#!/bin/sh
# From a bare Debian machine to a reconstructed surface: installs what is missing, builds, reconstructs the embedded
# example. Run it again at any time; only what changed is done again.
set -eu
cd "$(dirname "$0")/.."

scripts/install_packages.sh build

# A build folder that is set up for the tests stays so; a new one is made without them, to be there sooner.
if [ -f build/release/build.ninja ]; then
  scripts/build.sh gpsrecon_installed gpsrecon_datasets
else
  scripts/build.sh -DGPSRECON_BUILD_TESTS=OFF gpsrecon_installed gpsrecon_datasets
fi

result=build/quickstart
mkdir -p "$result"
echo
echo "gpsrecon build/release/datasets/example.ply $result/example.ply"
build/release/bin/gpsrecon build/release/datasets/example.ply "$result/example.ply"

for file in example.ply example.covmesh.ply example.report.json; do
  [ -s "$result/$file" ] || { echo "quickstart: $result/$file was not written" >&2; exit 1; }
done
cat <<END

mesh             $PWD/$result/example.ply
covariance mesh  $PWD/$result/example.covmesh.ply
report           $PWD/$result/example.report.json
END
