#!/usr/bin/python3
"""Is a run found in the map of another one? Cuts into recordings at random moments, with the map of a first recording.

  cut_ins.py FIRST OTHER... --count 40 --out runs/cut_ins

FIRST and OTHER are sequences of `facet simulate` with the same scene and seed and other flights. The simulator puts a room
around its flight, so that the worlds of their truths are shifted, by what truth/planes.csv tells. FIRST is run once, and
its map saved. Then runs of --duration seconds begin at random moments of the others (a fixed seed), with that map. The
error of a cut-in is that of its poses in the map, of which 95 % are nearer, where the map lies as the first run's final
trajectory says; beyond 0.2 m it is wrong. Seconds count from the first pose; who has none does not count.
Prints a line for each sequence and one for all. Exit code 1 if one is wrong.
"""

import argparse
import json
import math
import random
import shutil
import subprocess
import sys
from pathlib import Path

import naive_ate  # first: it may start another Python

import numpy as np

import trajectories

ROOT = Path(__file__).resolve().parents[1]
WRONG_M = 0.2


def world_shift(first, other):
    """What a position in the world of one truth is more than in that of the other, by the large planes of both."""
    def planes(sequence):
        lines = (sequence / "truth/planes.csv").read_text().splitlines()[1:]
        rows = [[float(value) for value in line.split(",")[1:6]] for line in lines if line]
        return np.array([row[:4] for row in rows if row[4] > 4])

    a, b = planes(first), planes(other)
    if a.shape != b.shape or np.abs(a[:, :3] - b[:, :3]).max() > 1e-6:
        sys.exit(f"{other} is not the scene of {first}: its planes are others")
    shift, *_ = np.linalg.lstsq(a[:, :3], b[:, 3] - a[:, 3], rcond=None)
    if np.abs(a[:, :3] @ shift - (b[:, 3] - a[:, 3])).max() > 1e-3:
        sys.exit(f"{other} is not the scene of {first}: its planes lie elsewhere")
    return shift


def has_poses(file):
    return file.exists() and any(line.strip() and not line.startswith("#") for line in file.read_text().splitlines())


def align(trajectory, truth):
    """Rotation about the vertical and translation that take the map to the truth."""
    pairs = truth.pairs(trajectory).values()
    R, _, t = naive_ate.align_yaw(np.array([pair[0] for pair in pairs]), np.array([pair[2] for pair in pairs]))
    return R, t


def run(arguments, sequence, out, *options):
    shutil.rmtree(out, ignore_errors=True)  # nothing of a run before is taken for this one
    command = [arguments.program, "run", sequence, "--quiet", "--out", out, *arguments.run_options, *options]
    subprocess.run([str(word) for word in command], stderr=subprocess.DEVNULL)  # a warning, where it is not found
    summary = Path(out) / "summary.json"
    return json.loads(summary.read_text()) if summary.exists() else None


def cut_in(arguments, sequence, truth, shift, to_truth, start, out):
    """(seconds from the first pose, or None; error in metres, or None), or None where there is no pose."""
    summary = run(arguments, sequence, out, "--map", arguments.out / "map", "--start", start,
                  "--duration", arguments.duration)
    odometry, in_map = out / "trajectory.tum", out / "trajectory_map.tum"
    if not summary or not has_poses(odometry):
        return None
    if not has_poses(in_map):
        return None, None
    R, t = to_truth
    pairs = truth.pairs(in_map)
    errors = [np.linalg.norm(R @ pair[0] + t - (pair[2] - shift)) for pair in pairs.values()]
    return (min(pairs) - naive_ate.read_trajectory(odometry)[0][0]) * 1e-9, float(np.quantile(errors, 0.95))


def describe(name, results):
    found = [(s, e) for s, e in results if s is not None]
    errors = sorted(e for _, e in found)
    share = lambda limit: 100 * sum(s <= limit for s, _ in found) / max(1, len(results))
    quantile = lambda q: 1e3 * errors[min(len(errors) - 1, int(q * len(errors)))] if errors else math.nan
    print(f"{name:28} {len(results):5d} {len(found):5d} {share(1):6.0f} {share(5):6.0f} {quantile(0.5):8.1f} "
          f"{quantile(0.95):8.1f} {sum(e > WRONG_M for e in errors):5d}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("first", type=Path)
    parser.add_argument("others", type=Path, nargs="+", metavar="OTHER")
    parser.add_argument("--count", type=int, default=40, help="of all cut-ins")
    parser.add_argument("--duration", type=float, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / "cut_ins")
    parser.add_argument("--program", default=ROOT / "build" / "facet")
    parser.add_argument("--run-options", nargs="*", default=["--pipeline", "S", "--set", "mesh.enabled=false"])
    arguments = parser.parse_args()
    first = arguments.out / "first"
    shutil.rmtree(arguments.out / "map", ignore_errors=True)
    if run(arguments, arguments.first, first, "--save-map", arguments.out / "map") is None:
        sys.exit(f"{arguments.first}: no result")
    to_truth = align(first / "trajectory_final.tum", trajectories.Truth(arguments.first))
    print(f"{'sequence':28} {'cuts':>5} {'found':>5} {'% 1 s':>6} {'% 5 s':>6} {'mm':>8} {'mm 95 %':>8} {'wrong':>5}")
    rng = random.Random(arguments.seed)
    everything = []
    for sequence in arguments.others:
        truth, shift = trajectories.Truth(sequence), world_shift(arguments.first, sequence)
        stamps = naive_ate.read_trajectory(trajectories.truth_file(sequence))[0]
        length = (stamps[-1] - stamps[0]) * 1e-9
        results = []
        for _ in range(max(1, arguments.count // len(arguments.others))):
            start = round(rng.uniform(0, max(0.0, length - arguments.duration - 1)), 2)
            result = cut_in(arguments, sequence, truth, shift, to_truth, start, arguments.out / "cut")
            if result is not None:
                results.append(result)
        describe(sequence.name, results)
        everything += results
    describe("all", everything)
    return 1 if any(e is not None and e > WRONG_M for _, e in everything) else 0


if __name__ == "__main__":
    sys.exit(main())
