#!/bin/sh
# scripts/try_wheel.sh [NAME=VALUE...]: installs the Python package by pip into a virtual environment of its own, without
# a network, and runs its tests there; then unpacks the source archive and builds the wheel from that. Settings are those
# of python/backend/facet_build.py. $PYTHON is the interpreter, $FACET_PROGRAM the program that its results are
# compared with.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
python=${PYTHON:-/usr/bin/python3}
if ! "$python" -c 'import venv, ensurepip, numpy, pytest' 2>/dev/null; then
  echo "skipped: $python lacks venv, numpy or pytest (Debian: python3-venv python3-numpy python3-pytest)"
  exit 77
fi
settings=""
for setting in "$@"; do
  settings="$settings --config-settings=$setting"
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset PYTHONPATH
export PYTHONDONTWRITEBYTECODE=1 PIP_DISABLE_PIP_VERSION_CHECK=1

"$python" -m venv --system-site-packages "$work/venv"
"$work/venv/bin/pip" install --quiet --no-build-isolation --no-index $settings .
cd "$work"
venv/bin/python -c "import facet; assert facet.__file__.startswith('$work'), facet.__file__; print('facet', facet.__version__)"
venv/bin/pip show facet | head -2
venv/bin/python "$root/python/tests/run_tests.py" -k "test_names or arrays"

# The same twice has the same bytes, and the archive of the sources is complete.
venv/bin/python - "$root" "$work" $settings <<'END'
import hashlib
import os
import subprocess
import sys
import tarfile
from pathlib import Path

root, work, *settings = sys.argv[1:]
settings = dict(text.split("=", 1)[1].split("=", 1) for text in settings)
sys.path.insert(0, f"{root}/python/backend")
import facet_build

sums = set()
for name in ("first", "second"):
    folder = Path(work, name)
    folder.mkdir()
    os.chdir(root)
    files = [folder / facet_build.build_wheel(folder, settings), folder / facet_build.build_sdist(folder)]
    sums.add(tuple(hashlib.sha256(file.read_bytes()).hexdigest() for file in files))
assert len(sums) == 1, "two builds differ"
with tarfile.open(files[1]) as archive:
    archive.extractall(work)
unpacked = Path(work, files[1].name.removesuffix(".tar.gz"))
if "package-dir" in settings:
    settings["package-dir"] = str(Path(root, settings["package-dir"]))
code = f"import facet_build; print(facet_build.build_wheel({work!r}, {settings!r}))"
subprocess.run([sys.executable, "-c", code], check=True, cwd=unpacked,
               env={**os.environ, "PYTHONPATH": str(unpacked / "python/backend")})
assert Path(work, files[0].name).read_bytes() == files[0].read_bytes() or "package-dir" not in settings
print("wheel", files[0].stat().st_size >> 10, "kB; sources", files[1].stat().st_size >> 10, "kB")
END
venv/bin/pip uninstall --quiet --yes facet
if venv/bin/python -c 'import facet' 2>/dev/null; then
  echo "try_wheel: facet is still there after pip uninstall" >&2
  exit 1
fi
echo "wheel: installed, tested, removed"
