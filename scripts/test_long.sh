#!/bin/sh
# scripts/test_long.sh [PART]...: what takes too long for every change; without arguments all parts. One line per part in
# runs/test-long/results.txt, with the commit. Each part is tried even if another failed; exit code 1 if any did.
#
#   headers   every header and source compiles alone, without precompiled headers          about 15 minutes on two cores
#   asan      every test under the address and undefined-behaviour sanitizers              about 90
#   tsan      what runs on two threads under the thread sanitizer                          about 20
#   fuzz      every reader of files under libFuzzer, FUZZ_SECONDS in all (default 600)     about 15
#   soak      flights of minutes: nothing lost, memory and time per frame stay level       about 15
set -u
cd "$(dirname "$0")/.."
scripts/setup.sh test || exit 1
out=runs/test-long
mkdir -p "$out"
commit=$(git describe --always --dirty 2>/dev/null || echo unknown)
failures=0

part() {
  name=$1
  shift
  echo "== $name (log: $out/$name.log)"
  start=$(date +%s)
  if "$@" >"$out/$name.log" 2>&1; then result=passed; else result=FAILED; failures=$((failures + 1)); fi
  line="$name $result, $(($(date +%s) - start)) s, $commit, $(date -u +%Y-%m-%d): $(tail -n 1 "$out/$name.log")"
  echo "$line"
  echo "$line" >>"$out/results.txt"
}

headers() {
  scripts/build.sh no-pch && scripts/check_headers.py build-no-pch/compile_commands.json
}

# Each test alone has 900 s; under the sanitizers some need more.
asan() {
  scripts/build.sh asan-ubsan &&
    ctest --test-dir build-asan --output-on-failure --parallel "$(nproc)" --timeout 3600 --no-tests=error &&
    grep "tests passed" "$out/asan.log"
}

tsan() {
  scripts/build.sh tsan threaded_vio_test run_sequence_test &&
    build-tsan/tests/threaded_vio_test && build-tsan/tests/run_sequence_test
}

fuzz() {
  clang=$(command -v clang++ clang++-14 clang++-19 | head -n 1)
  if [ -z "$clang" ]; then
    echo "no clang++: apt-get install clang libclang-rt-14-dev"
    return 1
  fi
  seeds=$out/seeds found=$out/found
  rm -rf "$seeds"
  mkdir -p "$seeds" "$found"
  cmake -S . -B build-fuzz -G Ninja -D CMAKE_CXX_COMPILER="$clang" -D CMAKE_BUILD_TYPE=RelWithDebInfo -D FACET_FUZZER=ON \
    -D FACET_BUILD_BENCH=OFF -D FACET_PCH=OFF -D FACET_SANITIZE=address,undefined,fuzzer-no-link &&
    cmake --build build-fuzz --target reader_fuzzer &&
    build-fuzz/reader_fuzzer --write-seeds="$seeds" &&
    build-fuzz/reader_fuzzer "$found" "$seeds" -max_total_time="${FUZZ_SECONDS:-600}" -max_len=20000 -timeout=20 \
      -rss_limit_mb=4096 -artifact_prefix="$out/" -print_final_stats=1
}

soak() {
  scripts/build.sh release facet && scripts/soak.py --duration "${SOAK_SECONDS:-240}"
}

[ $# -gt 0 ] || set -- headers asan tsan fuzz soak
for name in "$@"; do
  case $name in
    headers | asan | tsan | fuzz | soak) part "$name" "$name" ;;
    *)
      echo "test_long: '$name' is no part; see the head of $0" >&2
      exit 2
      ;;
  esac
done
[ "$failures" -eq 0 ]
