#!/bin/sh
# Makes the documentation as a site, build/docs/site: the pages of the project by MkDocs, the interface of the library by
# Doxygen. Fails on a broken link.
#
#   scripts/docs.sh
#
# Open build/docs/site/index.html; no server is needed.
set -eu
cd "$(dirname "$0")/.."

scripts/install_packages.sh docs
scripts/check_links.py

out=build/docs
rm -rf "$out"
mkdir -p "$out/pages" "$out/site"

# The pages link each other as the tree does, so the site has its folders.
cp ./*.md LICENSE "$out/pages"
mkdir "$out/pages/datasets"
cp datasets/*.md datasets/manifest.json "$out/pages/datasets"
cp -r docs "$out/pages"

# The headers that are installed.
version=$(sed -n 's/.* version = "\([0-9.]*\)".*/\1/p' lib/core/version.h)
headers=$(sed -n '/^set(GPSRECON_PUBLIC_HEADERS/,/)/s/^  \([a-z_/]*\.h\))\{0,1\}$/lib\/\1/p' cmake/install.cmake)
[ -n "$headers" ] || { echo "docs.sh: cmake/install.cmake lists no headers" >&2; exit 1; }
{
  cat docs/Doxyfile
  echo "PROJECT_NUMBER = $version"
  echo "OUTPUT_DIRECTORY = $out/pages"
  echo "INPUT = docs/api.dox" "$(echo "$headers" | tr '\n' ' ')"
} | doxygen -

mkdocs --quiet build --strict --config-file docs/mkdocs.yml --site-dir "$PWD/$out/site"
rm "$out/site/404.html"  # for servers; its links start at their root
scripts/check_links.py "$out/site"
echo "$PWD/$out/site/index.html"
