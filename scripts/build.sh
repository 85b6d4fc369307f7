#!/bin/sh
# scripts/build.sh [PRESET [TARGET]...]: configures a preset of CMakePresets.json and builds it, or these targets of it, through ccache if
# it is there.
set -eu
cd "$(dirname "$0")/.."
preset=${1:-release}
[ $# -eq 0 ] || shift
if command -v ccache >/dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
  export CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1  # other clones' results serve, too
  export CCACHE_SLOPPINESS=pch_defines,time_macros  # without it ccache does not cache what uses precompiled headers
fi
cmake --preset "$preset" --log-level=WARNING
cmake --build --preset "$preset" ${1:+--target "$@"}
