#!/bin/sh
# scripts/docs.sh: the API reference of the headers in build/docs/html/index.html. Fails on any warning of Doxygen, which is installed
# if it is missing.
set -eu
cd "$(dirname "$0")/.."
if ! command -v doxygen >/dev/null; then
  if ! command -v apt-get >/dev/null; then
    echo "docs: install doxygen first" >&2
    exit 1
  fi
  echo "docs: installing doxygen with apt"
  as_root=""
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  $as_root apt-get update -q
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends doxygen
fi
rm -rf build/docs
mkdir -p build/docs
doxygen docs/Doxyfile
echo "docs: build/docs/html/index.html"
