#!/bin/sh
# scripts/build.sh [PRESET]: configures a preset of CMakePresets.json and builds it, through ccache if it is there.
set -eu
cd "$(dirname "$0")/.."
preset=${1:-release}
if command -v ccache >/dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
  export CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1  # other clones' results serve, too
fi
cmake --preset "$preset" --log-level=WARNING
cmake --build --preset "$preset"
