#!/bin/sh
# scripts/test_long.sh [PART]...: what takes too long for every change; without arguments most parts.
# One line per part in runs/test-long/results.txt, with the commit. Each part is tried even if another failed; exit code
# 1 if any did. fuzz-ci, fuzz-totals and fuzz-keep have to be named.
#
#   headers   every header and source compiles alone, without precompiled headers          about 15 minutes on two cores
#   asan      every test but those of speed under the address and undefined-behaviour sanitizers   about 90
#   tsan      what runs on two threads under the thread sanitizer                          about 20
#   fuzz      readers of files, bags, IMU streams and the estimator under libFuzzer, a sixth of
#             FUZZ_SECONDS each (default 600)                                              about 25
#   fuzz-ci   the same with a minute each, from the inputs in testdata/fuzz alone          about 12
#   fuzz-totals   the same by number: ten million executions for text, a million for images, PLY,
#             bags and IMU streams, a hundred thousand for the estimator                   some hours
#   fuzz-keep     what the fuzzers have found, as few inputs as reach the same code, into testdata/fuzz
#   soak      flights of minutes: nothing lost, memory and time per frame stay level       about 15
#   large     an MCAP file of 2 GB is read: speed, and memory that stays level              about 1
set -u
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- headers asan tsan fuzz soak large
scripts/setup.sh test || exit 1
out=runs/test-long
mkdir -p "$out"
commit=$(git describe --always --dirty 2>/dev/null || echo unknown)
failures=0

part() {
  part=$1
  shift
  echo "== $part (log: $out/$part.log)"
  start=$(date +%s)
  if "$@" >"$out/$part.log" 2>&1; then result=passed; else result=FAILED; failures=$((failures + 1)); fi
  line="$part $result, $(($(date +%s) - start)) s, $commit, $(date -u +%Y-%m-%d): $(tail -n 1 "$out/$part.log")"
  echo "$line"
  [ "$result" = passed ] || tail -n 30 "$out/$part.log"
  echo "$line" >>"$out/results.txt"
}

headers() {
  scripts/build.sh no-pch && scripts/check_headers.py build-no-pch/compile_commands.json
}

# Programs and scripts that are tests have no limit of their own, and need longer under the sanitizers, too.
asan() {
  scripts/build.sh asan-ubsan &&
    ctest --test-dir build-asan --output-on-failure --parallel "$(nproc)" --timeout 3600 --no-tests=error \
      --label-exclude '^speed$' &&
    grep "tests passed" "$out/asan.log"
}

tsan() {
  scripts/build.sh tsan threaded_vio_test live_vio_test run_sequence_test view_server_test live_view_test publisher_test \
    robot_node_test &&
    build-tsan/tests/threaded_vio_test && build-tsan/tests/live_vio_test && build-tsan/tests/run_sequence_test &&
    build-tsan/tests/view_server_test && build-tsan/tests/live_view_test && build-tsan/tests/publisher_test &&
    build-tsan/tests/robot_node_test
}

# fuzz_build FOLDER BUILD_TYPE SANITIZERS TARGET...
fuzz_build() {
  folder=$1 type=$2 sanitizers=$3
  shift 3
  scripts/setup.sh fuzz || return 1
  clang=
  for name in clang++ clang++-14 clang++-19; do
    clang=$(command -v "$name") && break
  done
  if [ -z "$clang" ]; then
    echo "no clang++: scripts/setup.sh fuzz"
    return 1
  fi
  if command -v ccache >/dev/null; then
    export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1
  fi
  cmake -S . -B "$folder" -G Ninja -D CMAKE_CXX_COMPILER="$clang" -D CMAKE_BUILD_TYPE="$type" -D FACET_FUZZER=ON \
    -D CMAKE_CXX_FLAGS=-D_GLIBCXX_ASSERTIONS -D FACET_BUILD_BENCH=OFF -D FACET_PCH=OFF \
    -D FACET_SANITIZE="$sanitizers" &&
    cmake --build "$folder" --target "$@"
}

# fuzz_target NAME LIMIT PROGRAM [ARGUMENT]...: from the good inputs and from what earlier runs left in $found, until
# LIMIT (-max_total_time=S or -runs=N, and other options of libFuzzer). The readers' files are written to memory: a disk
# takes ten times as long as reading them. Entropic schedules and stack traces of all allocations cost more than the
# targets; a finding that is run alone without ASAN_OPTIONS has its traces.
fuzz_target() {
  name=$1 limit=$2 program=$3
  shift 3
  echo "-- $name, $limit"
  rm -rf "$out/seeds/$name" "$out/fuzz-$name.log"
  mkdir -p "$out/seeds/$name" "$found/$name"
  scratch=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")/facet-fuzz-XXXXXX")
  "$program" --write-seeds="$out/seeds/$name" "$@" || return 1
  TMPDIR=$scratch ASAN_OPTIONS=malloc_context_size=1:quarantine_size_mb=16 \
    "$program" "$found/$name" "$out/seeds/$name" $limit -timeout=20 -rss_limit_mb=4096 -entropic=0 \
    -print_funcs=0 -artifact_prefix="$out/$name-" -print_final_stats=1 "$@" 2>&1 | tee "$out/fuzz-$name.log"
  find "$out" -maxdepth 1 -name "$name-*" -newer "$out/seeds/$name" -print -exec base64 {} \;
  done=$(sed -n 's/^stat::number_of_executed_units: *//p' "$out/fuzz-$name.log")
  executions="${executions:+$executions, }$name ${done:-0}"
  rm -rf "$scratch"
  grep -q "^Done " "$out/fuzz-$name.log"  # not after a finding
}

fuzz_text="config,camera,kalibr,image_list,imu,trajectory,states,truth,planes,true_planes,json,basalt"
fuzz_text="$fuzz_text,kitti_calibration,kitti_times,kitti_oxts"

# fuzz_builds [TARGET]: it, too, with the address sanitizer
fuzz_builds() {
  fuzz_build build-fuzz RelWithDebInfo address,undefined,float-cast-overflow,fuzzer-no-link \
    reader_fuzzer recording_fuzzer imu_fuzzer "$@" &&
    fuzz_build build-fuzz-fast Release fuzzer-no-link,signed-integer-overflow,float-cast-overflow,bounds,shift \
      estimator_fuzzer
}

fuzz_all() {
  executions=
  # fuzz_limit NAME: what fuzz and fuzz-totals differ in. Text formats are lines: longer files only repeat them.
  fuzz_target text "$(fuzz_limit text)" build-fuzz/reader_fuzzer -max_len=4000 "--only=$fuzz_text" &&
    fuzz_target ply "$(fuzz_limit ply)" build-fuzz/reader_fuzzer -max_len=4000 --only=ply &&
    fuzz_target image "$(fuzz_limit image)" build-fuzz/reader_fuzzer -max_len=4000 --only=image &&
    fuzz_target recording "$(fuzz_limit recording)" build-fuzz/recording_fuzzer -max_len=20000 &&
    fuzz_target imu "$(fuzz_limit imu)" build-fuzz/imu_fuzzer -max_len=200 &&
    fuzz_target estimator "$(fuzz_limit estimator)" build-fuzz-fast/estimator_fuzzer -max_len=80
}

# The estimator is fifty times as slow under the address sanitizer: the fuzzer looks for ways through it without, then
# every way that it found is taken once with it.
fuzz_all_twice() {
  found="$out/found"
  fuzz_builds estimator_fuzzer && fuzz_all &&
    build-fuzz/estimator_fuzzer "$found/estimator" "$out/seeds/estimator" -runs=0 -timeout=60 &&
    echo "executions: $executions"
}

fuzz() {
  fuzz_limit() { echo "-max_total_time=$((${FUZZ_SECONDS:-600} / 6))"; }
  fuzz_all_twice
}

fuzz_totals() {
  fuzz_limit() {
    case $1 in
      text) echo -runs=10000000 ;;
      estimator) echo -runs=100000 ;;
      *) echo -runs=1000000 ;;
    esac
  }
  fuzz_all_twice
}

# What earlier runs have found does not count.
fuzz_ci() {
  found="$out/found-ci"
  rm -rf "$found"
  fuzz_limit() { echo "-max_total_time=60 -seed=1"; }
  fuzz_builds && fuzz_all && echo "executions: $executions"
}

# fuzz_keep_target TARGET FILE PROGRAM [READERS]: of what is in runs/test-long/found as much as reaches what neither the
# good inputs nor those of testdata/fuzz reach
fuzz_keep_target() {
  small="$out/small/$1"
  rm -rf "$small"
  mkdir -p "$small" "$out/found/$1"
  "$3" --write-seeds="$small" ${4:+"--only=$4"} &&
    "$3" -merge=1 -use_counters=0 -max_len=250 ${4:+"--only=$4"} "$small" "$out/found/$1" &&
    rm -f "$small"/seed-* &&
    scripts/keep_fuzz_inputs.py "$small" "testdata/fuzz/$2.txt" ${4:+--readers "$4"}
}

fuzz_keep() {
  fuzz_builds && fuzz_keep_target text readers build-fuzz/reader_fuzzer "$fuzz_text" &&
    fuzz_keep_target ply readers build-fuzz/reader_fuzzer ply &&
    fuzz_keep_target image readers build-fuzz/reader_fuzzer image &&
    fuzz_keep_target recording recording build-fuzz/recording_fuzzer &&
    fuzz_keep_target imu imu build-fuzz/imu_fuzzer &&
    fuzz_keep_target estimator estimator build-fuzz-fast/estimator_fuzzer
}

soak() {
  scripts/build.sh release facet && scripts/soak.py --duration "${SOAK_SECONDS:-240}"
}

large() {
  scripts/build.sh release large_recording && build/bench/large_recording --folder "$out"
}

for name in "$@"; do
  case $name in
    headers | asan | tsan | fuzz | soak | large) part "$name" "$name" ;;
    fuzz-ci) part "$name" fuzz_ci ;;
    fuzz-keep) part "$name" fuzz_keep ;;
    fuzz-totals) part "$name" fuzz_totals ;;
    *)
      echo "test_long: '$name' is no part; see the head of $0" >&2
      exit 2
      ;;
  esac
done
[ "$failures" -eq 0 ]
