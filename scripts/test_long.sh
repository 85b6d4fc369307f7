#!/bin/sh
# scripts/test_long.sh [PART]...: what takes too long for every change; without arguments all parts. One line per part in
# runs/test-long/results.txt, with the commit. Each part is tried even if another failed; exit code 1 if any did.
#
#   headers   every header and source compiles alone, without precompiled headers          about 15 minutes on two cores
#   asan      every test under the address and undefined-behaviour sanitizers              about 90
#   tsan      what runs on two threads under the thread sanitizer                          about 20
#   fuzz      readers of files, bags, IMU streams and the estimator under libFuzzer, a sixth of
#             FUZZ_SECONDS each (default 600)                                              about 25
#   soak      flights of minutes: nothing lost, memory and time per frame stay level       about 15
#   large     an MCAP file of 2 GB is read: speed, and memory that stays level              about 1
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

# fuzz_build FOLDER BUILD_TYPE SANITIZERS TARGET...
fuzz_build() {
  folder=$1 type=$2 sanitizers=$3
  shift 3
  clang=$(command -v clang++ clang++-14 clang++-19 | head -n 1)
  if [ -z "$clang" ]; then
    echo "no clang++: apt-get install clang libclang-rt-14-dev"
    return 1
  fi
  cmake -S . -B "$folder" -G Ninja -D CMAKE_CXX_COMPILER="$clang" -D CMAKE_BUILD_TYPE="$type" -D FACET_FUZZER=ON \
    -D CMAKE_CXX_FLAGS=-D_GLIBCXX_ASSERTIONS -D FACET_BUILD_BENCH=OFF -D FACET_PCH=OFF -D FACET_SANITIZE="$sanitizers" &&
    cmake --build "$folder" --target "$@"
}

# fuzz_target NAME SECONDS PROGRAM [ARGUMENT]...: from the good inputs and from what earlier runs found.
fuzz_target() {
  name=$1 seconds=$2 program=$3
  shift 3
  echo "-- $name, $seconds s"
  rm -rf "$out/seeds/$name"
  mkdir -p "$out/seeds/$name" "$out/found/$name"
  "$program" --write-seeds="$out/seeds/$name" "$@" &&
    "$program" "$out/found/$name" "$out/seeds/$name" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=4096 \
      -artifact_prefix="$out/$name-" -print_final_stats=1 "$@"
}

# The estimator is fifty times as slow under the sanitizers: the fuzzer looks for ways through it without them, then
# every way that it found is taken once with them.
fuzz() {
  share=$((${FUZZ_SECONDS:-600} / 6))
  text="config,camera,kalibr,image list,imu,trajectory,states,truth,planes,true planes,json"
  text="$text,kitti calibration,kitti times,kitti oxts"
  fuzz_build build-fuzz RelWithDebInfo address,undefined,float-cast-overflow,fuzzer-no-link \
    reader_fuzzer recording_fuzzer imu_fuzzer estimator_fuzzer &&
    fuzz_build build-fuzz-fast Release fuzzer-no-link,signed-integer-overflow,float-cast-overflow,bounds,shift \
      estimator_fuzzer &&
    fuzz_target text "$share" build-fuzz/reader_fuzzer -max_len=20000 "--only=$text" &&
    fuzz_target ply "$share" build-fuzz/reader_fuzzer -max_len=4000 --only=ply &&
    fuzz_target image "$share" build-fuzz/reader_fuzzer -max_len=4000 --only=image &&
    fuzz_target recording "$share" build-fuzz/recording_fuzzer -max_len=20000 &&
    fuzz_target imu "$share" build-fuzz/imu_fuzzer -max_len=200 &&
    fuzz_target estimator "$share" build-fuzz-fast/estimator_fuzzer -max_len=80 &&
    build-fuzz/estimator_fuzzer "$out/found/estimator" "$out/seeds/estimator" -runs=0 -timeout=60
}

soak() {
  scripts/build.sh release facet && scripts/soak.py --duration "${SOAK_SECONDS:-240}"
}

large() {
  scripts/build.sh release large_recording && build/bench/large_recording --folder "$out"
}

[ $# -gt 0 ] || set -- headers asan tsan fuzz soak large
for name in "$@"; do
  case $name in
    headers | asan | tsan | fuzz | soak | large) part "$name" "$name" ;;
    *)
      echo "test_long: '$name' is no part; see the head of $0" >&2
      exit 2
      ;;
  esac
done
[ "$failures" -eq 0 ]
