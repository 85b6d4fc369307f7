#!/usr/bin/python3
"""Each plane of a result beside the true plane it belongs to.

    scripts/plane_list.py RESULT SEQUENCE

RESULT must have been evaluated (`facet evaluate RESULT --truth SEQUENCE`): the alignment is taken from there.
"""

import csv
import json
import sys
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np

# As in PlaneErrorOptions (src/facet/eval/plane_error.h).
MAX_ANGLE_DEG, MAX_OFFSET_M, MAX_AREA_RATIO = 10, 0.10, 4
MIN_AREA_M2, MIN_SEEN_AREA_M2, MIN_VISIBLE_AREA_M2 = 1, 1, 0.01
MAX_FLAT_ANGLE_DEG, MAX_FLAT_OFFSET_M, MIN_FLAT_AREA_RATIO = 0.1, 0.02, 4


class Truth:
    def __init__(self, row):
        self.name = f"{row[7]} ({row[0]})" if len(row) > 7 else row[0]  # labels are not unique
        self.n, self.d = np.array(row[1:4], float), float(row[4])
        self.area, self.seen = float(row[5]), float(row[6])


class Estimate:
    def __init__(self, row, R, t):
        self.row, self.area = row, float(row["area_m2"])
        self.n = R @ np.array([row["nx"], row["ny"], row["nz"]], float)
        n_W, centre_W = (np.array([row[a + b] for b in "xyz"], float) for a in "nc")
        self.centre = R @ (centre_W - (n_W @ centre_W - float(row["d"])) * n_W) + t


class Surface:
    """A true plane and what lies flat on it."""

    def __init__(self, largest):
        self.planes, self.area = [largest], largest.area

    @property
    def seen(self):
        return sum(plane.seen for plane in self.planes)

    def holds(self, plane):
        largest = self.planes[0]
        return (self.area >= MIN_FLAT_AREA_RATIO * plane.area and angle_deg(plane.n, largest.n) <= MAX_FLAT_ANGLE_DEG and
                abs(plane.d - largest.d) <= MAX_FLAT_OFFSET_M)

    def counts(self):
        return self.area > MIN_AREA_M2 and self.seen >= MIN_SEEN_AREA_M2


def angle_deg(n, m):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(n, m)), n @ m))


def rotation(q):
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def read_surfaces(file):
    rows = [r for r in csv.reader(open(file)) if r and not r[0].startswith("#") and r[0] != "plane"]
    surfaces = []
    for plane in sorted(map(Truth, rows), key=lambda plane: -plane.area):
        surface = next((s for s in surfaces if s.holds(plane)), None)
        if surface:
            surface.planes.append(plane)
        else:
            surfaces.append(Surface(plane))
    return [s for s in surfaces if s.seen >= MIN_VISIBLE_AREA_M2]


def compare(estimate, surface):
    """Score, angle, offset and name of the plane of the surface that is most like the estimate."""
    compared = []
    for plane in surface.planes:
        angle, offset = angle_deg(estimate.n, plane.n), plane.n @ estimate.centre - plane.d
        angle = min(angle, 180 - angle)
        compared.append((angle / MAX_ANGLE_DEG + abs(offset) / MAX_OFFSET_M, angle, offset, plane.name))
    return min(compared, key=lambda c: (not within(c), c[0]))


def within(compared):
    return compared[1] <= MAX_ANGLE_DEG and abs(compared[2]) <= MAX_OFFSET_M


def one_to_one(estimates, surfaces):
    """For each estimate what it was compared with and a remark, and the surfaces found."""
    compared = [[compare(e, s) for s in surfaces] for e in estimates]
    pairs = [(compared[e][s][0], -surface.seen, s, e) for s, surface in enumerate(surfaces)
             for e, estimate in enumerate(estimates)
             if within(compared[e][s]) and estimate.area <= MAX_AREA_RATIO * surface.area]
    surface_of, best_of = {}, {}
    for _, _, s, e in sorted(pairs):
        best_of.setdefault(e, s)
        if e not in surface_of and s not in surface_of.values():
            surface_of[e] = s
    judged = []
    for e in range(len(estimates)):
        if e in surface_of:
            judged.append((compared[e][surface_of[e]], ""))
        elif e in best_of:
            judged.append((compared[e][best_of[e]], "  <-- duplicate"))
        else:
            judged.append((min(compared[e], default=(0, np.nan, np.nan, "")), "  <-- not there"))
    return judged, set(surface_of.values())


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    result, sequence = Path(sys.argv[1]), Path(sys.argv[2])
    alignment = json.load(open(result / "evaluation.json"))["alignment"]
    R, t = rotation(alignment["rotation_wxyz"]), np.array(alignment["translation_m"])
    surfaces = read_surfaces(sequence / "truth" / "planes.csv")
    estimates = [Estimate(row, R, t) for row in csv.DictReader(open(result / "planes.csv"))]
    judged, found = one_to_one(estimates, surfaces)
    print("  id orientation  label     area    landmarks  angle deg  offset cm  sigma deg  sigma cm  truth")
    for estimate, ((_, angle, offset, name), remark) in zip(estimates, judged):
        row = estimate.row
        print(f"{row['id']:>4} {row['orientation']:<12} {row['label']:<8} {estimate.area:6.2f} {row['landmarks']:>8} "
              f"{angle:10.2f} {100 * offset:10.2f} {np.degrees(float(row['sigma_normal_rad'])):10.2f} "
              f"{100 * float(row['sigma_d_m']):9.2f}  {name}{remark}")
    print(f"not found, larger than {MIN_AREA_M2} m2 and at least {MIN_SEEN_AREA_M2} m2 seen, with what lies flat on it:")
    for s, surface in enumerate(surfaces):
        if s not in found and surface.counts():
            print(f"  {surface.planes[0].name}: {surface.seen:.1f} m2")


if __name__ == "__main__":
    main()
