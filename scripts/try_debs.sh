#!/bin/sh
# scripts/try_debs.sh [FOLDER]: installs the Debian packages of FOLDER (build/packages without it) into a bare Debian 12
# that mmdebstrap makes of what apt of this machine knows, and tries them there: program, Python package, and the examples
# built against libfacet-dev. Must be root, or user namespaces must be allowed. --mode of mmdebstrap is $MODE: auto, root,
# unshare.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
debs=$(cd "${1:-build/packages}" && pwd)
if ! command -v mmdebstrap >/dev/null; then
  echo "skipped: mmdebstrap is not installed (Debian: apt install mmdebstrap)"
  exit 77
fi
ls "$debs"/facet_*.deb "$debs"/libfacet-dev_*.deb "$debs"/python3-facet_*.deb >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# What happens in the bare system, one package after the other.
mkdir -p "$work/try/debs"
cp "$debs"/*.deb "$work/try/debs"
cp -r examples bench/python_overhead.py "$work/try"
cat > "$work/try/try.sh" <<'END'
set -eu
export DEBIAN_FRONTEND=noninteractive
cd /try
install_deb() { apt-get install -q -y --no-install-recommends "$@" >apt.log 2>&1 || { cat apt.log; exit 1; }; }

echo "== facet"
install_deb ./debs/facet_*.deb
facet --version
facet simulate --out flight --duration 3 --quiet
facet run flight --out result --quiet
facet evaluate result --truth flight | head -12
test "$(wc -l < result/trajectory.tum)" -gt 30
test -s /usr/share/facet/config/paper.yaml
facet run flight --out paper --quiet --config /usr/share/facet/config/paper.yaml

echo "== python3-facet"
install_deb ./debs/python3-facet_*.deb
python3 - <<'PYTHON'
import facet
facet.run("flight", "result-python")
for name in ("trajectory.tum", "map.ply", "planes.csv", "config.yaml"):
    with open(f"result/{name}", "rb") as a, open(f"result-python/{name}", "rb") as b:
        assert a.read() == b.read(), name
print("facet.run writes the same bytes, ATE", facet.evaluate("result-python", "flight")["ate"]["rmse_m"])
PYTHON
python3 python_overhead.py flight

echo "== libfacet-dev"
install_deb ./debs/libfacet-dev_*.deb g++ cmake make
for example in library:at_rest shared_library:fly; do
  cmake -S "examples/${example%:*}" -B "build-${example%:*}" -D CMAKE_BUILD_TYPE=Release >cmake.log || { cat cmake.log; exit 1; }
  cmake --build "build-${example%:*}" >cmake.log || { cat cmake.log; exit 1; }
  "build-${example%:*}/${example#*:}"
done
g++ -std=c++17 -O1 $(pkg-config --cflags facet) examples/shared_library/tracker.cpp examples/shared_library/fly.cpp -o fly \
  $(pkg-config --libs facet)
./fly

echo "== removed"
apt-get remove -q -y facet python3-facet libfacet-dev >apt.log 2>&1
if test -e /usr/bin/facet || python3 -c 'import facet' 2>/dev/null || test -e /usr/include/facet; then
  echo "something is left behind" >&2
  exit 1
fi
END

sources=$(cat /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/debian*.sources 2>/dev/null || true)
suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
printf '%s\n' "$sources" | mmdebstrap --quiet --mode="${MODE:-auto}" --variant=apt \
  --aptopt='Acquire::Check-Valid-Until "false"' \
  --customize-hook="copy-in '$work/try' /" --customize-hook='chroot "$1" sh /try/try.sh' \
  "$suite" /dev/null -
echo "packages: installed, tried and removed in a bare $suite"
