#!/usr/bin/python3
"""How far two trajectories of the same recording are apart, without any alignment.

  compare_runs.py RESULT OTHER --max-metres 1e-4

Prints the largest and the median difference of position and rotation. Exit code 1 where a stamp is in one of them only,
or a difference of position is larger than --max-metres. For the same program on another processor: scripts/arm64.sh.
"""

import argparse
import math
import statistics
import sys
from pathlib import Path

import naive_ate  # first: it may start another Python

import numpy as np


def read(folder):
    """{stamp in ns: (position, quaternion)}"""
    file = Path(folder) / "trajectory.tum"
    if not any(line.strip() and not line.startswith("#") for line in file.read_text().splitlines()):
        return {}
    stamps, positions, rotations = naive_ate.read_trajectory(file)
    return {stamp: pose for stamp, *pose in zip(stamps, positions, rotations)}


def turn(a, b):
    """Degrees between two unit quaternions; by their difference, because a cosine near 1 has few digits."""
    distance = min(math.dist(a, b), math.dist(a, -b))
    return math.degrees(4 * math.asin(min(1.0, distance / 2)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("result")
    parser.add_argument("other")
    parser.add_argument("--max-metres", type=float, default=math.inf)
    arguments = parser.parse_args()
    a, b = read(arguments.result), read(arguments.other)
    if set(a) != set(b) or not a:
        print(f"{len(set(a) ^ set(b))} stamps are in one of them only, {len(set(a) & set(b))} in both")
        return 1
    if not all(np.isfinite(part).all() for poses in (a, b) for pose in poses.values() for part in pose):
        print("a pose has a value that is not finite")
        return 1
    metres = [math.dist(a[stamp][0], b[stamp][0]) for stamp in a]
    degrees = [turn(a[stamp][1], b[stamp][1]) for stamp in a]
    print(f"{len(a)} poses: positions {max(metres):.2g} m apart at most, {statistics.median(metres):.2g} m in the median; "
          f"{max(degrees):.2g} and {statistics.median(degrees):.2g} degrees")
    return 0 if max(metres) <= arguments.max_metres else 1


if __name__ == "__main__":
    sys.exit(main())
