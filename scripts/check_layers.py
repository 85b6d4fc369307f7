#!/usr/bin/env python3
"""Fails where a file includes a folder that is not below its own.

A folder may include folders of a lower rank. Folders of the same rank are siblings that meet only in
the data of lower folders. Tests may also use the simulator, the file readers, the evaluation and testing/.
testing/NAME holds what the tests of folder NAME share: it may include what they may.

Inside a folder of PARTS the same holds for its sub-folders, and for what lies beside them.
"""

import re
import sys
from pathlib import Path

RANK = {
    "base": 0,
    "geometry": 1,
    "camera": 2,
    "imu": 2,
    "map": 3,
    "calibration": 3,
    "frontend": 4,
    "estimator": 4,
    "mesh": 4,
    "regularities": 5,
    "plausibility": 5,
    "loop": 5,
    "io": 6,
    "sim": 6,
    "eval": 6,
    "pipeline": 6,
    "messages": 7,
    "recording": 8,
    "live": 8,
    "report": 8,
    "render": 8,
    "viewer": 8,
    "facade": 9,
    "publish": 9,
    "check": 9,
    "faults": 9,
    "robot": 10,
    "apps": 10,
    "bench": 10,
    "python": 11,
    "ros1": 11,
    "ros2": 11,
    "dds": 11,
    "studies": 11,
}
# Folders with sub-folders, lowest first; sub-folders in one set are siblings. What lies in the folder itself
# comes last, but for headers that are named here. Tests may use all of their folder.
PARTS = {
    "estimator": [{"estimator_options.h"}, {"window"}, {"factors"}, {"solver", "planes"}, {"start"}],
}
# Siblings that may meet: the evaluation judges what the readers read.
SIDEWAYS = {("eval", "io")}
FOR_TESTS = {"testing", "sim", "io", "eval"}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]')


def folder_of(path):
    """The name in RANK of a source file relative to the root of the repository, or testing/NAME."""
    parts = path.parts
    if parts[:2] != ("src", "facet"):
        return parts[0]
    if len(parts) == 3:
        return "facade"  # facet/facet.h
    return "/".join(parts[2:4]) if parts[2] == "testing" and len(parts) > 4 else parts[2]


def included_folder(header):
    parts = header.split("/")
    if parts[0] == "facet" and len(parts) > 2:
        return parts[1]
    return parts[0] if parts[0] in ("apps", "bench", "python", "studies") else None


def is_allowed(folder, other, is_test):
    if folder == other or (folder, other) in SIDEWAYS:
        return True
    if folder == "testing":
        return RANK.get(other, 99) <= RANK["map"]
    if folder.startswith("testing/"):
        return is_allowed(folder.split("/")[1], other, True)
    if is_test and other in FOR_TESTS:
        return True
    return other in RANK and RANK[other] < RANK[folder]


def part_rank(folder, inside):
    """How high a file lies in a folder of PARTS; `inside`: its path from there."""
    parts = PARTS[folder]
    name = inside.split("/")[0]
    return name, next((rank for rank, names in enumerate(parts) if name in names), len(parts))


def is_allowed_inside(folder, inside, header):
    prefix = f"facet/{folder}/"
    if folder not in PARTS or not header.startswith(prefix):
        return True
    name, rank = part_rank(folder, inside)
    other, other_rank = part_rank(folder, header.removeprefix(prefix))
    return other_rank < rank or other == name or rank == len(PARTS[folder])


def complaints(root, path):
    relative = path.relative_to(root)
    folder = folder_of(relative)
    inside = "/".join(relative.parts[3:])
    if folder.removeprefix("testing/") not in {*RANK, "testing"}:
        yield f"{relative}: folder '{folder}' has no rank in scripts/check_layers.py"
        return
    is_test = path.stem.endswith("_test") or folder in ("bench", "studies")
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        header = match.group(1)
        other = included_folder(header)
        if other and not is_allowed(folder, other, is_test):
            yield f"{relative}:{number}: '{folder}' may not include '{other}' ({header})"
        elif not is_test and not is_allowed_inside(folder, inside, header):
            yield f"{relative}:{number}: '{inside}' may not include '{header}', which is not below it"


def main():
    root = Path(__file__).resolve().parent.parent
    files = [p for top in ("src", "apps", "bench", "python", "ros1", "ros2", "dds", "studies") for p in sorted((root / top).rglob("*"))
             if p.suffix in (".h", ".cpp") and "node_modules" not in p.parts]
    found = [text for path in files for text in complaints(root, path)]
    for text in found:
        print(text, file=sys.stderr)
    print(f"layers: {len(files)} files, {len(found)} includes that point the wrong way")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
