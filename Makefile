# Thin: every target is one script or one CMake call. Works on a fresh clone of the repository.
PRESET ?= release
PREFIX ?= /usr/local
SEQUENCE ?=
DATA ?=

.PHONY: all setup setup-test build demo test test-long bench format docs viewer deb ros1 dds install clean
all: build

setup:  ## install the Debian packages that the program needs and that are missing
	@scripts/setup.sh

setup-test:  ## the same with those of tests, benchmarks and checks
	@scripts/setup.sh test

build: setup  ## build/facet, without tests and benchmarks
	@scripts/build.sh $(PRESET) facet

demo: build  ## run and evaluate one sequence: make demo [SEQUENCE=dir]
	@scripts/demo.sh "$(SEQUENCE)"

test: setup-test  ## every test; SANITIZE=1 first runs the unit tests under the sanitizers (half an hour more)
	@scripts/test.sh $(PRESET)

test-long: setup-test  ## what takes hours: sanitizers over every test, fuzzing, long flights, headers that compile alone
	@scripts/test_long.sh

bench: setup-test  ## kernels, then the end-to-end table over every sequence found: make bench [DATA=dir]
	@scripts/build.sh $(PRESET)
	@scripts/bench.sh "$(DATA)"

format:  ## clang-format on every source file
	@scripts/format.sh

docs:  ## the API reference in build/docs/html; installs doxygen if it is missing
	@scripts/docs.sh

viewer:  ## the page of the viewer, viewer/dist, anew from viewer/src; needs Node 18 and npm
	@scripts/viewer.sh

deb:  ## the Debian packages facet, libfacet-dev and python3-facet in build/packages
	@scripts/setup.sh deb
	@scripts/deb.sh $(PRESET)

ros1:  ## the node for ROS 1, build/ros1/facet_ros; installs what is missing of ROS
	@scripts/setup.sh ros1
	@scripts/build.sh $(PRESET) facet_node

dds:  ## build/facet-dds, the node of ROS 2 on Cyclone DDS, without ROS; installs what is missing
	@scripts/setup.sh dds
	@scripts/build.sh $(PRESET) facet-dds

install: setup  ## make install PREFIX=...
	@scripts/build.sh $(PRESET) installable
	@cmake --install build --prefix "$(PREFIX)"

clean:
	rm -rf build build-package build-wheel build-asan build-tsan build-fuzz build-fuzz-fast build-no-pch build-debug
