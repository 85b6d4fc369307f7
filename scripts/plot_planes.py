#!/usr/bin/python3
"""Draws the planes of a result from above and from the side, with the trajectory.

    scripts/plot_planes.py RESULT PICTURE.png
"""

import csv
import sys
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

COLOURS = {"floor": "tab:green", "wall": "tab:blue", "table": "tab:orange", "ceiling": "tab:gray", "other": "tab:red"}


def read_planes(file):
    with open(file) as stream:
        for row in csv.DictReader(stream):
            corners = [[float(v) for v in corner.split()] for corner in row["outline"].split(";") if corner]
            if corners:
                yield row["id"], row["label"], np.array(corners + corners[:1])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    result = Path(sys.argv[1])
    trajectory = np.loadtxt(result / "trajectory.tum", ndmin=2)
    figure, axes = plt.subplots(2, 1, figsize=(9, 10), height_ratios=[3, 1])
    for axis, (i, j), name in zip(axes, ((0, 1), (0, 2)), ("from above", "from the side")):
        for plane, label, corners in read_planes(result / "planes.csv"):
            axis.plot(corners[:, i], corners[:, j], color=COLOURS[label], linewidth=1.5)
            axis.annotate(plane, corners[:-1, [i, j]].mean(axis=0), fontsize=8)
        axis.plot(trajectory[:, 1 + i], trajectory[:, 1 + j], color="black", linewidth=0.7)
        axis.set_aspect("equal")
        axis.set_xlabel("x [m]")
        axis.set_ylabel("xyz"[j] + " [m]")
        axis.set_title(name)
    for label, colour in COLOURS.items():
        axes[0].plot([], [], color=colour, label=label)
    axes[0].legend(loc="best", fontsize=8)
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=70)


if __name__ == "__main__":
    main()
