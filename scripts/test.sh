#!/bin/sh
# scripts/test.sh [PRESET]: every test in the optimised build. With SANITIZE=1 the unit tests first run
# under the address and undefined-behaviour sanitizers; that build takes half an hour on two cores.
set -eu
cd "$(dirname "$0")/.."
preset=${1:-release}
jobs=$(nproc)

if [ "${SANITIZE:-0}" != 0 ]; then
  echo "== unit tests with -fsanitize=address,undefined"
  scripts/build.sh asan-ubsan
  ctest --test-dir build-asan --label-regex unit --output-on-failure --parallel "$jobs" --no-tests=error
fi

echo "== every test, preset $preset"
scripts/build.sh "$preset"
ctest --test-dir build --output-on-failure --parallel "$jobs" --no-tests=error
