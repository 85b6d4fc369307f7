#!/bin/sh
# scripts/test.sh [PRESET]: the unit tests under the address and undefined-behaviour sanitizers
# (SANITIZE=0 leaves them out), then every test in the optimised build.
set -eu
cd "$(dirname "$0")/.."
preset=${1:-release}
jobs=$(nproc)

if [ "${SANITIZE:-1}" != 0 ]; then
  echo "== unit tests with -fsanitize=address,undefined"
  scripts/build.sh asan-ubsan
  ctest --test-dir build-asan --label-regex unit --output-on-failure --parallel "$jobs"
fi

echo "== every test, preset $preset"
scripts/build.sh "$preset"
ctest --test-dir build --output-on-failure --parallel "$jobs"
