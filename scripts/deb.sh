#!/bin/sh
# scripts/deb.sh [PRESET]: the Debian packages facet, libfacet-dev and python3-facet in build/packages, of what the preset
# builds in build, looked through by lintian. `dpkg-buildpackage --build=binary` compiles all of it anew.
set -eu
cd "$(dirname "$0")/.."
preset=${1:-release}
version=$(dpkg-parsechangelog --show-field Version)
if ! grep -q "project(facet VERSION $version " CMakeLists.txt; then
  echo "deb: debian/changelog is of version $version, CMakeLists.txt is not" >&2
  exit 1
fi
dpkg-checkbuilddeps

scripts/build.sh "$preset" installable facet_python
export FACET_BUILT=build FACET_DEB_FOLDER="$PWD/build/packages"
rm -rf "$FACET_DEB_FOLDER"
mkdir -p "$FACET_DEB_FOLDER"
dh_clean
debian/rules binary
dh_clean
lintian --fail-on error,warning "$FACET_DEB_FOLDER"/*.deb
ls -l "$FACET_DEB_FOLDER"
