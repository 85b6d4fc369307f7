#!/bin/sh
# scripts/build_commit.sh COMMIT [CMAKE_ARGUMENT...]: builds the program of another commit beside the current one, once, and prints its
# path. The checkout lies in build-commits/<commit>; its configuration files are in config/ there.
set -eu
cd "$(dirname "$0")/.."
commit=$(git rev-parse --verify --quiet "${1:?which commit?}^{commit}") || {
  echo "build_commit: '$1' is no commit of this repository" >&2
  exit 2
}
shift
folder="$PWD/build-commits/$(git rev-parse --short=10 "$commit")"
if [ ! -e "$folder/.git" ]; then
  git worktree prune
  git worktree add --quiet --force --detach "$folder" "$commit" >&2
fi
if [ ! -x "$folder/build/facet" ]; then
  if command -v ccache >/dev/null; then
    export CMAKE_CXX_COMPILER_LAUNCHER=ccache
    export CCACHE_BASEDIR="$folder" CCACHE_NOHASHDIR=1
  fi
  cmake -S "$folder" -B "$folder/build" -G Ninja -D CMAKE_BUILD_TYPE=Release -D FACET_BUILD_TESTS=OFF \
    -D FACET_BUILD_BENCH=OFF --log-level=WARNING "$@" >&2
  cmake --build "$folder/build" --target facet >&2
fi
echo "$folder/build/facet"
