#!/usr/bin/python3
"""What recognised places bring: errors with them over errors without, from the same runs.

  loops_table.py SEQUENCE ...                    three starts each
  loops_table.py --starts 9 --set loops.min_inliers=30 SEQUENCE ...

Odometry is the same with and without loops, so one run has all three trajectories: of the odometry
(trajectory.tum), in the map as it was known at each frame (trajectory_map.tum), and in the map as it was known at the
end (trajectory_final.tum). Prints their ATE [mm], how many comparisons became closures, how many of these are wrong by
more than 10 cm or 1 deg against ground truth, and the processor time of the work on places as a share of the recording's
duration. Starts are 0.45 s apart.
"""

import argparse
import csv
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import naive_ate  # noqa: E402
import trajectories  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
START_STEP_S = 0.45
WRONG_M, WRONG_DEG = 0.10, 1.0
KINDS = ("trajectory.tum", "trajectory_map.tum", "trajectory_final.tum")


def relative_error(pairs, row):
    """How far a closure's relative pose is off: [m], [deg]; None where there is no truth."""
    stamps = np.array(sorted(pairs))
    nearest = [stamps[np.argmin(np.abs(stamps - int(row[key])))]
               for key in ("place_timestamp_ns", "timestamp_ns")]
    (p_a, _, g_a, h_a), (p_b, q_b, g_b, h_b) = (pairs[t] for t in nearest)
    yaw = np.radians(float(row["yaw_deg"]))
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    p_said = turn @ p_b + np.array([float(row[k]) for k in ("dx", "dy", "dz")])
    R_a = naive_ate.rotation(pairs[nearest[0]][1])
    said = R_a.T @ (p_said - p_a), R_a.T @ turn @ naive_ate.rotation(q_b)
    true = naive_ate.rotation(h_a).T @ (g_b - g_a), naive_ate.rotation(h_a).T @ naive_ate.rotation(h_b)
    cosine = (np.trace(said[1].T @ true[1]) - 1) / 2
    return np.linalg.norm(said[0] - true[0]), np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def run_once(program, sequence, start_s, settings, folder):
    command = [program, "run", str(sequence), "--out", str(folder), "--quiet", "--start", f"{start_s:.2f}",
               "--set", "loops.enabled=true"]
    for setting in settings:
        command += ["--set", setting]
    subprocess.run(command, check=True, capture_output=True, text=True)
    truth = trajectories.Truth(sequence)
    figures = {}
    for kind in KINDS:
        pairs = truth.pairs(folder / kind)
        figures[kind] = 1e3 * trajectories.ate_rmse_on(pairs, sorted(pairs))
        if kind == KINDS[0]:
            odometry = pairs
    rows = [row for row in csv.DictReader(open(folder / "closures.csv", encoding="utf-8"))
            if row["verdict"] == "accepted"]
    errors = [relative_error(odometry, row) for row in rows]
    figures["errors_m"] = [e[0] for e in errors]
    figures["wrong"] = sum(e[0] > WRONG_M or e[1] > WRONG_DEG for e in errors)
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    figures.update(summary["loops"], duration_s=summary["duration_s"])
    return figures


def print_sequence(name, runs):
    medians = {kind: statistics.median(run[kind] for run in runs) for kind in KINDS}
    ratios = {kind: [run[kind] / run[KINDS[0]] for run in runs] for kind in KINDS}
    errors = [1e3 * e for run in runs for e in run["errors_m"]]
    print(f"{name:26s} {medians[KINDS[0]]:8.2f} "
          + " ".join(f"{medians[k]:8.2f} {statistics.median(ratios[k]):5.2f} ({max(ratios[k]):4.2f})" for k in KINDS[1:])
          + f" {sum(r['closures'] for r in runs):5d} of {sum(r['compared'] for r in runs):5d}"
          + f" {sum(r['wrong'] for r in runs):3d} {statistics.median(errors) if errors else 0:6.1f}"
          + f" {max(r['memory_mb'] for r in runs):6.1f}"
          + f" {100 * statistics.mean(r['cpu_s'] / r['duration_s'] for r in runs):5.1f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", nargs="+", type=Path)
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--program", default=str(ROOT / "build" / "facet"))
    parser.add_argument("--set", action="append", default=[], dest="settings")
    arguments = parser.parse_args()
    print(f"{'':26s} {'odometry':>8s} {'causal map':>21s} {'final':>21s} {'closures':>14s} wrong mm    MB     cpu %")
    for sequence in arguments.sequences:
        runs = []
        for number in range(arguments.starts):
            with tempfile.TemporaryDirectory() as folder:
                runs.append(run_once(arguments.program, sequence, START_STEP_S * number, arguments.settings,
                                     Path(folder) / "run"))
        print_sequence(sequence.name, runs)


if __name__ == "__main__":
    main()
