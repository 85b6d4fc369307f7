#!/usr/bin/python3
"""Question: how much does the map grow with each lap of a sequence that goes around more than once?
Command: studies/map_growth.py SEQUENCE --from S [--facet build/facet] [-- ARGUMENTS OF facet run]
  A lap is over when the true path is back at the place of second S, in the same direction. One run up to the end of
  each lap, with the map that is written there.
Answer: the second lap of a ring of 72 m adds 4.5 % of memory and 4.4 % of area (docs/notebook/map_growth.md).
Date: 2026-11-21 and 2026-11-22.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "scripts"))
import render_mesh  # noqa: E402

NEAR_M, SAME_DIRECTION, LEAST_LAP_S = 0.6, 0.7, 5


def ends_of_laps(sequence, begin_s):
    """Seconds after the first image at which the path is back where it was at `begin_s`."""
    folder = Path(sequence) / "mav0"
    stamps = np.loadtxt(folder / "cam0/data.csv", delimiter=",", usecols=0, dtype=np.int64, ndmin=1)
    truth = folder / "state_groundtruth_estimate0/data.csv"
    t = np.loadtxt(truth, delimiter=",", usecols=0, dtype=np.int64)
    state = np.loadtxt(truth, delimiter=",", usecols=(1, 2, 3, 8, 9, 10))
    seconds = (t - stamps[0]) * 1e-9
    last = (stamps[-1] - stamps[0]) * 1e-9
    place = state[np.searchsorted(seconds, begin_s)]
    distance = np.linalg.norm(state[:, :3] - place[:3], axis=1)
    speeds = np.linalg.norm(state[:, 3:], axis=1) * np.linalg.norm(place[3:])
    direction = state[:, 3:] @ place[3:] / np.maximum(speeds, 1e-9)
    ends, after = [], begin_s + LEAST_LAP_S
    while True:
        near = (seconds > after) & (seconds <= last) & (distance < NEAR_M) & (direction > SAME_DIRECTION)
        if not near.any():
            return ends
        first = np.argmax(near)
        away = np.flatnonzero(~near[first:])
        passing = slice(first, first + away[0] if away.size else None)
        ends.append(seconds[passing][np.argmin(distance[passing])])
        after = ends[-1] + LEAST_LAP_S


def area_of(path):
    vertices, faces = render_mesh.read_ply(path)[:2]
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def map_after(arguments, duration_s, folder):
    out = folder / f"{duration_s:.2f}"
    command = [arguments.facet, "run", arguments.sequence, "--out", out, "--quiet", "--duration", f"{duration_s:.2f}"]
    subprocess.run(command + arguments.rest, check=True)
    summary = json.loads((out / "summary.json").read_text())
    figures = {"vertices": summary["map_vertices"], "faces": summary["map_faces"], "m2": area_of(out / "map.ply")}
    figures["MB"] = summary["map_memory_mb"]
    return figures


def main():
    own = sys.argv[1:]
    rest = own[own.index("--") + 1:] if "--" in own else []
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence")
    parser.add_argument("--from", dest="begin", type=float, required=True, metavar="S")
    parser.add_argument("--facet", default="build/facet")
    arguments = parser.parse_args(own[:len(own) - len(rest) - 1] if rest else own)
    arguments.rest = rest
    ends = ends_of_laps(arguments.sequence, arguments.begin)
    if not ends:
        sys.exit(f"the path never comes back to where it is after {arguments.begin} s")
    before = None
    with tempfile.TemporaryDirectory() as folder:
        for lap, end_s in enumerate(ends, 1):
            figures = map_after(arguments, end_s, Path(folder))
            growth = "".join(f", {k} {100 * (v / before[k] - 1):+.1f} %" for k, v in figures.items()) if before else ""
            print(f"lap {lap}, {end_s:.1f} s: " + ", ".join(f"{v:.5g} {k}" for k, v in figures.items()) + growth)
            before = figures


if __name__ == "__main__":
    main()
