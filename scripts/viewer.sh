#!/bin/sh
# scripts/viewer.sh [--check | --browser FACET FOLDER | --large-map FACET FOLDER | --foxglove FACET FOLDER]: builds the
# viewer's page, viewer/dist, with npm. --check builds it elsewhere and fails where the committed one is another.
# --browser tests the page of the program FACET in Chromium, with what it writes below FOLDER. --large-map prints how many
# pictures per second there are of a map of 500 000 faces that turns. --foxglove reads what that program publishes and
# records with Foxglove's own packages (npm ci in viewer/foxglove installs them). All say what is not there, if something
# is not, and exit with 77: ctest takes it for skipped.
set -eu
cd "$(dirname "$0")/../viewer"
if [ "${1:-}" = --browser ]; then
  if ! command -v node >/dev/null; then
    echo "viewer: skipped, there is no Node"
    exit 77
  fi
  exec node test/run.mjs "$2" "$3" "${FACET_DATA_DIR:-$PWD/../../shared/data}"
fi
if [ "${1:-}" = --large-map ]; then
  if ! command -v node >/dev/null; then
    echo "large map: skipped, there is no Node"
    exit 77
  fi
  exec node test/large_map.mjs "$2" "$3"
fi
if [ "${1:-}" = --foxglove ]; then
  if ! command -v node >/dev/null; then
    echo "foxglove: skipped, there is no Node"
    exit 77
  fi
  exec node foxglove/test.mjs "$2" "$3/foxglove" "${FACET_DATA_DIR:-$PWD/../../shared/data}/rendered_room"
fi
if [ "${1:-}" != --check ]; then
  npm ci --no-audit --no-fund
  npm run --silent build
  exit 0
fi
if ! command -v npm >/dev/null; then
  echo "viewer: skipped, there is no npm"
  exit 77
fi
if [ ! -d node_modules ]; then
  echo "viewer: skipped, viewer/node_modules is not there; 'make viewer' installs it"
  exit 77
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
npx tsc --noEmit
npx vite build --logLevel error --emptyOutDir --outDir "$folder"
if ! diff -rq dist "$folder"; then
  echo "viewer: viewer/dist is not what viewer/src gives; run 'make viewer' and commit it" >&2
  exit 1
fi
size=$(gzip -9c dist/page.js dist/page.css dist/index.html | wc -c)
echo "viewer: the page is $size bytes compressed"
[ "$size" -le 350000 ]
