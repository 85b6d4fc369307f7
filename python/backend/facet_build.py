# SPDX-License-Identifier: BSD-2-Clause
"""Build backend of the Python package (PEP 517, 660): calls CMake and packs the wheel itself, without requirements.

Settings, each as --config-settings NAME=VALUE of pip:
  build-dir     folder that CMake builds in; default: build-wheel. A second build there takes seconds.
  cmake-args    more arguments of CMake, with blanks between them
  package-dir   folder with a package that is built already, such as build/python/facet; then nothing is built
"""

import base64
import csv
import gzip
import hashlib
import io
import os
import re
import shlex
import shutil
import stat
import subprocess
import sys
import sysconfig
import tarfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NAME = "facet"
# A wheel, and an archive, of the same files has the same bytes.
EPOCH = int(os.environ.get("SOURCE_DATE_EPOCH", "1704067200"))  # the beginning of 2024
SKIPPED_FOLDERS = {".git", "__pycache__", "runs", "bench-out", "node_modules"}


class BuildError(RuntimeError):
    """Why nothing was built, and what to do."""


def version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(facet VERSION ([\d.]+)", text).group(1)


def project_field(name):
    """A text of [project]; Python before 3.11 cannot read TOML, and the file is ours."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    return re.search(rf'(?m)^{name} = "(.*)"$', text).group(1)


def project_list(text, name):
    return re.findall(r'"([^"]+)"', re.search(rf"(?ms)^{name} = \[(.*?)\]", text).group(1))


def metadata():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    lines = [
        "Metadata-Version: 2.1",
        f"Name: {NAME}",
        f"Version: {version()}",
        f"Summary: {project_field('description')}",
        "License: BSD-2-Clause",
        f"Requires-Python: {project_field('requires-python')}",
        *(f"Classifier: {classifier}" for classifier in project_list(text, "classifiers")),
        *(f"Requires-Dist: {requirement}" for requirement in project_list(text, "dependencies")),
        "Provides-Extra: plot",
        'Requires-Dist: matplotlib; extra == "plot"',
        "Description-Content-Type: text/markdown",
    ]
    return "\n".join(lines) + "\n\n" + (ROOT / project_field("readme")).read_text(encoding="utf-8")


def wheel_tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"{python}-{python}-{platform}"


def wheel_text():
    return f"Wheel-Version: 1.0\nGenerator: facet_build {version()}\nRoot-Is-Purelib: false\nTag: {wheel_tag()}\n"


# What is compiled.


def run(*command):
    try:
        subprocess.run([str(part) for part in command], cwd=ROOT, check=True)
    except FileNotFoundError as error:
        raise BuildError(f"{command[0]} is not installed; scripts/setup.sh test installs what is missing") from error
    except subprocess.CalledProcessError as error:
        raise BuildError(f"{' '.join(map(str, command))} failed; what it needs is installed by scripts/setup.sh "
                         "test") from error


def cmake_options():
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "FACET_BUILD_TESTS": "OFF",
        "FACET_BUILD_BENCH": "OFF",
        "FACET_BUILD_PYTHON": "REQUIRED",
        "Python_EXECUTABLE": sys.executable,
    }
    if shutil.which("ccache"):
        options["CMAKE_CXX_COMPILER_LAUNCHER"] = "ccache"
        os.environ.setdefault("CCACHE_BASEDIR", str(ROOT))
        os.environ.setdefault("CCACHE_NOHASHDIR", "1")
        os.environ.setdefault("CCACHE_SLOPPINESS", "pch_defines,time_macros")
    return [f"-D{name}={value}" for name, value in options.items()]


def build(settings):
    """The folder with the built package."""
    settings = settings or {}
    if "package-dir" in settings:
        return (ROOT / settings["package-dir"]).resolve()
    folder = (ROOT / settings.get("build-dir", "build-wheel")).resolve()
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    run("cmake", "-S", ROOT, "-B", folder, *generator, *cmake_options(), *shlex.split(settings.get("cmake-args", "")))
    run("cmake", "--build", folder, "--target", "facet_python", "--parallel", os.cpu_count() or 1)
    return folder / "python" / NAME


# What is packed.


def is_packed(path):
    return path.suffix in (".py", ".pyi", ".so") or path.name == "py.typed"


class Wheel:
    """A wheel under construction; keeps the record of its files."""

    def __init__(self, file):
        self.zip = zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED)
        self.rows = []
        self.info = f"{NAME}-{version()}.dist-info"

    def add(self, name, data, mode=0o644):
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        self.rows.append((name, f"sha256={digest}", len(data)))
        self._write(name, data, mode)

    def _write(self, name, data, mode):
        entry = zipfile.ZipInfo(name, date_time=time.gmtime(EPOCH)[:6])
        entry.external_attr = (stat.S_IFREG | mode) << 16
        entry.compress_type = zipfile.ZIP_DEFLATED
        self.zip.writestr(entry, data)

    def close(self):
        for name, text in info_files().items():
            self.add(f"{self.info}/{name}", text.encode())
        record = io.StringIO()
        csv.writer(record, lineterminator="\n").writerows([*self.rows, (f"{self.info}/RECORD", "", "")])
        self._write(f"{self.info}/RECORD", record.getvalue().encode(), 0o644)
        self.zip.close()


def info_files():
    return {
        "METADATA": metadata(),
        "WHEEL": wheel_text(),
        # Facet's own and three.js's, which is in the page of the viewer that `facet run --view` has.
        "LICENSE": (ROOT / "viewer/dist/licences.txt").read_text(encoding="utf-8"),
    }


def pack(wheel_directory, fill):
    name = f"{NAME}-{version()}-{wheel_tag()}.whl"
    wheel = Wheel(Path(wheel_directory) / name)
    fill(wheel)
    wheel.close()
    return name


def source_files():
    """What git knows, or, without it, all that is no product."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                            capture_output=True, check=False) if (ROOT / ".git").exists() else None
    if listed and listed.returncode == 0:
        names = listed.stdout.decode().split("\0")
        return sorted(path for name in names if name and (path := ROOT / name).is_file())
    found = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in SKIPPED_FOLDERS and not name.startswith("build-")
                      and name != "build"]
        found += [Path(folder, name) for name in names if name != "PKG-INFO"]
    return sorted(found)


# The hooks that pip calls.


def get_requires_for_build_wheel(config_settings=None):
    return []


def get_requires_for_build_sdist(config_settings=None):
    return []


def get_requires_for_build_editable(config_settings=None):
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    folder = Path(metadata_directory) / f"{NAME}-{version()}.dist-info"
    folder.mkdir(parents=True)
    for name, text in info_files().items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder.name


prepare_metadata_for_build_editable = prepare_metadata_for_build_wheel


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    package = build(config_settings)

    def fill(wheel):
        for path in sorted(filter(is_packed, package.iterdir())):
            wheel.add(f"{NAME}/{path.name}", path.read_bytes(), 0o755 if path.suffix == ".so" else 0o644)

    return pack(wheel_directory, fill)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """The package in the build folder, whose Python files are links to those in the tree."""
    package = build(config_settings)
    return pack(wheel_directory, lambda wheel: wheel.add(f"{NAME}.pth", f"{package.parent}\n".encode()))


def build_sdist(sdist_directory, config_settings=None):
    stem = f"{NAME}-{version()}"
    with open(Path(sdist_directory) / f"{stem}.tar.gz", "wb") as file, gzip.GzipFile(
        filename="", mode="wb", fileobj=file, mtime=EPOCH
    ) as zipped, tarfile.open(fileobj=zipped, mode="w", format=tarfile.PAX_FORMAT) as archive:

        def add(name, data, mode):
            entry = tarfile.TarInfo(f"{stem}/{name}")
            entry.size, entry.mode, entry.mtime = len(data), mode, EPOCH
            archive.addfile(entry, io.BytesIO(data))

        add("PKG-INFO", metadata().encode(), 0o644)
        for path in source_files():
            mode = 0o755 if os.access(path, os.X_OK) else 0o644
            add(path.relative_to(ROOT).as_posix(), path.read_bytes(), mode)
    return f"{stem}.tar.gz"
