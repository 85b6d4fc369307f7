#!/usr/bin/python3
"""Draws a trajectory over its ground truth (three views) and its error over time.

  plot_run.py RESULT --truth SEQUENCE|FILE [--out FILE.png]
RESULT is a result folder of `facet run` or a trajectory file. Aligned with SE(3), no scale.
"""

import argparse
import sys
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

sys.path.insert(0, str(Path(__file__).resolve().parent))
import trajectories  # noqa: E402

VIEWS = (("from above", 0, 1), ("from the front", 0, 2), ("from the side", 1, 2))
AXES = "xyz"


def draw_views(axes, estimate, truth):
    for axis, (name, i, j) in zip(axes, VIEWS):
        axis.plot(truth[:, i], truth[:, j], color="0.6", linewidth=2.5, label="ground truth")
        axis.plot(estimate[:, i], estimate[:, j], color="tab:blue", linewidth=0.9, label="estimate, aligned")
        axis.plot(*truth[0, [i, j]], "o", color="black", markersize=5, label="start")
        axis.set_title(name)
        axis.set_xlabel(f"{AXES[i]} [m]")
        axis.set_ylabel(f"{AXES[j]} [m]")
        axis.set_aspect("equal", adjustable="datalim")
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize="small")


def break_at_gaps(seconds, values, longest=0.5):
    """Nan where frames are missing, so that no line is drawn across."""
    gaps = np.flatnonzero(np.diff(seconds) > longest) + 1
    return np.insert(seconds, gaps, seconds[gaps - 1]), np.insert(values, gaps, np.nan, axis=0)


def draw_error(axis, seconds, difference):
    times, parts = break_at_gaps(seconds, difference)
    for k, color in enumerate(("tab:red", "tab:green", "tab:purple")):
        axis.plot(times, 1000 * parts[:, k], color=color, linewidth=0.8, label=f"{AXES[k]}, estimate - truth")
    axis.plot(times, 1000 * np.linalg.norm(parts, axis=1), color="black", linewidth=1.2, label="distance")
    axis.set_xlabel("time since the first pose with truth [s]")
    axis.set_ylabel("position error [mm]")
    axis.grid(alpha=0.3)
    axis.legend(fontsize="small", ncol=4)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("result", type=Path)
    parser.add_argument("--truth", type=Path, required=True)
    parser.add_argument("--out", type=Path, help="default: trajectory.png in RESULT, or beside the file")
    arguments = parser.parse_args()

    is_folder = arguments.result.is_dir()
    file = arguments.result / "trajectory.tum" if is_folder else arguments.result
    if not file.is_file():
        sys.exit(f"plot_run: {file}: there is no such file")
    if trajectories.truth_file(arguments.truth) is None:
        sys.exit(f"plot_run: {arguments.truth}: no ground truth")
    pairs = trajectories.Truth(arguments.truth).pairs(file)
    if len(pairs) < 3:
        sys.exit("plot_run: fewer than 3 poses have a ground truth")
    stamps, estimate, truth = trajectories.aligned_positions(pairs)
    seconds = np.array([(t - stamps[0]) * 1e-9 for t in stamps])
    rmse = np.sqrt(np.mean(np.sum((estimate - truth) ** 2, axis=1)))

    figure, grid = plt.subplot_mosaic([["a", "b", "c"], ["error"] * 3], figsize=(13, 8), height_ratios=[3, 2])
    draw_views([grid[k] for k in "abc"], estimate, truth)
    draw_error(grid["error"], seconds, estimate - truth)
    figure.suptitle(f"{arguments.result.resolve().name}: {len(stamps)} poses, ATE rmse {1000 * rmse:.1f} mm")
    figure.tight_layout()
    out = arguments.out or (arguments.result / "trajectory.png" if is_folder else file.with_suffix(".png"))
    figure.savefig(out, dpi=110)
    print(f"plot_run: {out}")


if __name__ == "__main__":
    main()
