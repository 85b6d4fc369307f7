#!/usr/bin/python3
"""Are several runs one map after `facet map merge`? Runs each sequence alone with a map of its own, merges the maps one
after the other, and compares.

  merge_maps.py FIRST OTHER... --out runs/merge_maps
  merge_maps.py FIRST OTHER... --apart         of different scenes: no two maps may be merged, in either order

Sequences of `facet simulate` with the same scene and seed and different flights, as for cut_ins.py. For each run it prints
the error of its places (RMS, aligned to its own truth): in its own map and in the merged one; and the error in the merged
map where that is aligned by the places of the first run alone, which shows how well the runs lie on each other.
Exit code 1 if maps were not merged, or with --apart if any were.
"""

import argparse
import itertools
import re
import shutil
import subprocess
import sys
from pathlib import Path

import naive_ate  # first: it may start another Python

import numpy as np

import cut_ins
import trajectories

ROOT = Path(__file__).resolve().parents[1]


def facet(arguments, *words):
    command = [str(word) for word in (arguments.program, *words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout.strip()


def try_apart(arguments, count):
    """How many pairs of places were compared and looked alike, over all ordered pairs of maps; and how many were merged."""
    compared = alike = merged = 0
    for first, second in itertools.permutations(range(1, count + 1), 2):
        words = [arguments.program, "map", "merge", arguments.out / f"run{first}-map", arguments.out / f"run{second}-map",
                 arguments.out / "apart"]
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
        numbers = re.search(r"\((\d+) of (\d+) pairs", done.stderr)
        if done.returncode == 0 or numbers is None:
            merged += 1
            print(f"{first} and {second}: {done.stdout}{done.stderr}")
            shutil.rmtree(arguments.out / "apart", ignore_errors=True)
            continue
        alike += int(numbers[1])
        compared += int(numbers[2])
    print(f"{count * (count - 1)} pairs of maps, {compared} pairs of places: {alike} look alike, {merged} merged")
    return merged


def rms_mm(errors):
    return 1e3 * float(np.sqrt(np.mean(np.square(errors))))


def errors_after(alignment, pairs, shift):
    R, t = alignment
    return [np.linalg.norm(R @ pair[0] + t - (pair[2] - shift)) for pair in pairs.values()]


def own_error_mm(file, truth):
    return rms_mm(errors_after(cut_ins.align(file, truth), truth.pairs(file), np.zeros(3)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("first", type=Path)
    parser.add_argument("others", type=Path, nargs="+", metavar="OTHER")
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / "merge_maps")
    parser.add_argument("--program", default=ROOT / "build" / "facet")
    parser.add_argument("--run-options", nargs="*", default=["--pipeline", "S", "--set", "mesh.enabled=false"])
    parser.add_argument("--apart", action="store_true")
    arguments = parser.parse_args()
    shutil.rmtree(arguments.out, ignore_errors=True)
    sequences = [arguments.first, *arguments.others]
    for number, sequence in enumerate(sequences, 1):
        run = arguments.out / f"run{number}"
        facet(arguments, "run", sequence, "--quiet", "--out", run, *arguments.run_options, "--save-map", f"{run}-map")
    if arguments.apart:
        sys.exit(1 if try_apart(arguments, len(sequences)) else 0)
    merged = arguments.out / "run1-map"
    for number in range(2, len(sequences) + 1):
        out = arguments.out / f"merged{number}"
        print(facet(arguments, "map", "merge", merged, arguments.out / f"run{number}-map", out))
        merged = out
    print(f"{'sequence':28} {'own map mm':>11} {'merged mm':>10} {'by the first mm':>16}")
    for number, sequence in enumerate(sequences, 1):
        truth = trajectories.Truth(sequence)
        own, both = arguments.out / f"own{number}.tum", arguments.out / f"both{number}.tum"
        facet(arguments, "map", "export", arguments.out / f"run{number}-map", own)
        facet(arguments, "map", "export", merged, both, "--run", number)
        if number == 1:
            by_first, shift = cut_ins.align(both, truth), np.zeros(3)
        else:
            shift = cut_ins.world_shift(arguments.first, sequence)
        print(f"{sequence.name:28} {own_error_mm(own, truth):11.1f} {own_error_mm(both, truth):10.1f} "
              f"{rms_mm(errors_after(by_first, truth.pairs(both), shift)):16.1f}")


if __name__ == "__main__":
    main()
