#!/bin/sh
# Bundles the 3-D view of the report page, lib/report/html/viewer.js, with the parts of three.js it uses into
# viewer.min.js, which is part of the sources: building gpsrecon needs no JavaScript tools. Needs npm; run it after a
# change of viewer.js.
set -eu
cd "$(dirname "$0")/.."
here=$PWD

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent three@0.187 esbuild@0.28
cp "$here/lib/report/html/viewer.js" .
npx esbuild viewer.js --bundle --minify --format=iife --target=es2020 --legal-comments=inline \
  --outfile="$here/lib/report/html/viewer.min.js"
