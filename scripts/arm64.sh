#!/bin/sh
# scripts/arm64.sh [--tests REGEX] [SEQUENCE]: builds Facet for 64 bit ARM on another machine, runs its unit tests and a
# recording under qemu-user, and compares the trajectory with that of build/facet on this machine (scripts/compare_runs.py).
# The packages for ARM are unpacked below build-arm64/sysroot, never installed. Exit code 77 and the reason where a tool is
# missing: apt-get install g++-aarch64-linux-gnu qemu-user-static mmdebstrap.
set -eu
tests=.
if [ "${1:-}" = --tests ]; then
  tests=$2
  shift 2
fi
if [ $# -gt 0 ]; then
  sequence=$(cd "$1" && pwd)
fi
cd "$(dirname "$0")/.."
sequence=${sequence:-${FACET_DATA_DIR:-../shared/data}/euroc_mh01_handheld}
for tool in aarch64-linux-gnu-g++ qemu-aarch64-static mmdebstrap; do
  if ! command -v "$tool" >/dev/null; then
    echo "skipped: there is no $tool (Debian: apt-get install g++-aarch64-linux-gnu qemu-user-static mmdebstrap)"
    exit 77
  fi
done

sysroot=build-arm64/sysroot
if [ ! -e $sysroot/complete ]; then
  echo "== packages for ARM, unpacked below $sysroot"
  rm -rf $sysroot
  mkdir -p build-arm64
  mmdebstrap --quiet --architectures=arm64 --variant=extract --include="libc6-dev libstdc++-12-dev libeigen3-dev
libopencv-core-dev libopencv-imgproc-dev libopencv-features2d-dev libboost-dev libyaml-cpp-dev libcli11-dev
nlohmann-json3-dev libnanoflann-dev libpng-dev libdeflate-dev libjpeg62-turbo-dev libwebp-dev libembree-dev libsqlite3-dev
liblz4-dev libzstd-dev libbz2-dev zlib1g-dev libgtest-dev libgmock-dev libceres-dev" bookworm $sysroot
  # What Debian's alternatives do where packages are installed.
  for name in blas lapack; do
    ln -sf $name/lib$name.so.3 $sysroot/usr/lib/aarch64-linux-gnu/lib$name.so.3
    ln -sf lib$name.so.3 $sysroot/usr/lib/aarch64-linux-gnu/lib$name.so
  done
  touch $sysroot/complete
fi

echo "== build"
scripts/build.sh arm64
echo "== unit tests under qemu"
ctest --test-dir build-arm64 --label-regex unit --tests-regex "$tests" --output-on-failure --parallel "$(nproc)" --timeout 3600 \
  --no-tests=error
if [ ! -e "$sequence" ]; then
  echo "skipped: no recording $sequence"
  exit 0
fi
echo "== $sequence under qemu, and here"
scripts/build.sh release facet
run() {
  out=$1
  shift
  rm -rf "runs/arm64/$out"
  "$@" run "$sequence" --quiet --out "runs/arm64/$out"
}
run arm qemu-aarch64-static -L $sysroot build-arm64/facet
run here build/facet
scripts/compare_runs.py runs/arm64/arm runs/arm64/here --max-metres 1e-4
