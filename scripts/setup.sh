#!/bin/sh
# scripts/setup.sh [test|fuzz|deb|ros1|dds]: installs the Debian packages that the program and the demo are built with,
# and with "test" those of the Python package, tests, benchmarks and checks, too; with "fuzz" those and a compiler with
# libFuzzer; with "deb" those that Debian packages are made with; with "ros1" those of the node for ROS 1 and of its
# test; with "dds" those of the node on Cyclone DDS.
# Does nothing, quickly, when all are there.
set -eu

# What a demo needs; python3 draws its picture.
packages="g++ cmake ninja-build ccache pkg-config
libeigen3-dev libopencv-core-dev libopencv-imgproc-dev libopencv-features2d-dev
libboost-dev libyaml-cpp-dev libcli11-dev nlohmann-json3-dev libnanoflann-dev
libpng-dev libdeflate-dev libjpeg62-turbo-dev libwebp-dev libembree-dev
libsqlite3-dev liblz4-dev libzstd-dev libbz2-dev zlib1g-dev
python3 python3-numpy python3-matplotlib"
of_tests="libgtest-dev libgmock-dev libbenchmark-dev libceres-dev libcgal-dev clang-format clang-tidy
pybind11-dev python3-dev python3-pytest python3-venv python3-yaml python3-pil cyclonedds-dev cyclonedds-tools"
case "${1:-}" in
  "") ;;
  test) packages="$packages $of_tests" ;;
  fuzz) packages="$packages $of_tests clang libclang-rt-dev" ;;
  dds) packages="$packages cyclonedds-dev cyclonedds-tools" ;;
  deb) packages="$packages debhelper dh-python lintian pybind11-dev python3-dev" ;;
  ros1) packages="$packages libroscpp-dev libdiagnostic-msgs-dev libgeometry-msgs-dev libnav-msgs-dev libsensor-msgs-dev
libstd-msgs-dev libstd-srvs-dev libtf2-msgs-dev libvisualization-msgs-dev ros-core python3-rospy python3-rosbag
python3-diagnostic-msgs python3-geometry-msgs python3-nav-msgs python3-sensor-msgs python3-std-srvs python3-tf2-msgs
python3-visualization-msgs python3-pil" ;;
  *)
    echo "usage: scripts/setup.sh [test|fuzz|deb|ros1|dds]" >&2
    exit 2
    ;;
esac
if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "setup: not a Debian system. Install the equivalents of these packages yourself:" $packages >&2
  exit 0
fi

missing=""
for package in $packages; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing="$missing $package"
done
if [ -z "$missing" ]; then
  exit 0
fi

echo "setup: installing with apt:$missing"
as_root=""
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "setup: not root and no sudo; run as root: apt-get install$missing" >&2
    exit 1
  fi
  echo "setup: this needs root, so sudo may ask for your password"
  as_root=sudo
fi
$as_root apt-get update -q
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
