#!/usr/bin/python3
"""Question: what do planes cost where floors are not level and walls not plumb?
Command: studies/leaning_ground.py SEQUENCE OUT [--deg 0.5] [--towards 30]
  Copies a simulated sequence so that gravity leans by this angle against the scene: floors and walls all lean, and
  nothing in the images tells. All other files are hard links: do not edit them in place. `facet run OUT` and `facet
  evaluate` as usual; the ATE's alignment (se3) takes the angle out of it, and NEES mean nothing.
Answer: with 0.5 degrees SPR has 0.75 to 1.25 of the ATE of S with relations of 0.3 degrees and 0.72 to 1.61 with 0.7
  (docs/notebook/planes_gates.md).
Date: 2026-11-29.
"""

import argparse
import os
import shutil
from pathlib import Path

import numpy as np
from truth_lag import rotations

GRAVITY_MPS2 = 9.81


def data_rows(file):
    with open(file) as stream:
        return [line.rstrip("\n").split(",") for line in stream if line.strip() and not line.startswith("#")]


def orientations_at(stamps, sequence):
    """True rotations of body into world at these stamps, or just after them."""
    truth = data_rows(sequence / "mav0" / "state_groundtruth_estimate0" / "data.csv")
    true_stamps = np.array([int(row[0]) for row in truth])
    near = np.clip(np.searchsorted(true_stamps, stamps), 0, len(truth) - 1)
    return rotations(np.array([[float(value) for value in row[4:8]] for row in truth])[near])


def lean(rows, R_WB, deg, towards_deg):
    """Accelerations with the specific force of gravity turned by this angle in the world."""
    angle, towards = np.radians([deg, towards_deg])
    change_W = GRAVITY_MPS2 * np.array([np.sin(angle) * np.cos(towards), np.sin(angle) * np.sin(towards),
                                        np.cos(angle) - 1])
    accelerations = np.array([[float(value) for value in row[4:7]] for row in rows])
    return accelerations + np.einsum("nji,j->ni", R_WB, change_W)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--deg", type=float, default=0.5)
    parser.add_argument("--towards", type=float, default=30, help="from the world's x axis [deg]")
    arguments = parser.parse_args()
    if arguments.out.exists():
        parser.error(f"{arguments.out} exists")
    shutil.copytree(arguments.sequence, arguments.out, copy_function=os.link)
    file = arguments.out / "mav0" / "imu0" / "data.csv"
    with open(file) as stream:
        head = [line for line in stream if line.startswith("#")]
    rows = data_rows(file)
    stamps = np.array([int(row[0]) for row in rows])
    accelerations = lean(rows, orientations_at(stamps, arguments.sequence), arguments.deg, arguments.towards)
    file.unlink()  # the sequence's own file stays as it is
    with open(file, "w") as stream:
        stream.writelines(head)
        for row, acceleration in zip(rows, accelerations):
            stream.write(",".join(row[:4] + [f"{value:.9g}" for value in acceleration]) + "\n")


if __name__ == "__main__":
    main()
