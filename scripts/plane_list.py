#!/usr/bin/env python3
"""Each plane of a result beside the true plane it belongs to.

    scripts/plane_list.py RESULT SEQUENCE

RESULT must have been evaluated (`facet evaluate RESULT --truth SEQUENCE`): the alignment is taken from there.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np

MAX_ANGLE_DEG, MAX_OFFSET_M = 10, 0.10


def rotation(q):
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def read_truth(file):
    rows = [r for r in csv.reader(open(file)) if r and not r[0].startswith("#") and r[0] != "plane"]
    return [(r[7], np.array(r[1:4], float), float(r[4]), float(r[6])) for r in rows]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    result, sequence = Path(sys.argv[1]), Path(sys.argv[2])
    alignment = json.load(open(result / "evaluation.json"))["alignment"]
    R, t = rotation(alignment["rotation_wxyz"]), np.array(alignment["translation_m"])
    truth = read_truth(sequence / "truth" / "planes.csv")
    found = set()
    print("  id orientation  label     area    landmarks  angle deg  offset cm  sigma deg  sigma cm  truth")
    for row in csv.DictReader(open(result / "planes.csv")):
        n = R @ np.array([row["nx"], row["ny"], row["nz"]], float)
        centre = R @ np.array([row["cx"], row["cy"], row["cz"]], float) + t
        best = None
        for name, n_true, d_true, _ in truth:
            angle = np.degrees(np.arccos(min(1.0, abs(n @ n_true))))
            offset = n_true @ centre - d_true
            score = angle / MAX_ANGLE_DEG + abs(offset) / MAX_OFFSET_M
            if best is None or score < best[0]:
                best = (score, name, angle, offset)
        _, name, angle, offset = best
        wrong = "" if angle < MAX_ANGLE_DEG and abs(offset) < MAX_OFFSET_M else "  <-- not there"
        found.add(name)
        print(f"{row['id']:>4} {row['orientation']:<12} {row['label']:<8} {float(row['area_m2']):6.2f} {row['landmarks']:>8} "
              f"{angle:10.2f} {100 * offset:10.2f} {np.degrees(float(row['sigma_normal_rad'])):10.2f} "
              f"{100 * float(row['sigma_d_m']):9.2f}  {name}{wrong}")
    print("not found, with at least 0.5 m2 seen:")
    for name, _, _, seen in truth:
        if name not in found and seen >= 0.5:
            print(f"  {name}: {seen:.1f} m2")


if __name__ == "__main__":
    main()
