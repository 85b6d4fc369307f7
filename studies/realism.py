#!/usr/bin/python3
"""Question: how does a simulated sequence compare with recorded ones, to the front end? Corners per image, strength of the
  corners, track life, share of points found in the right image, error of the tracked pixels, and how fast the images
  move. The last columns are the ratios; '!' marks those beyond a factor of 1.5. Sequences need ground truth.
Command: studies/realism.py SEQUENCE REFERENCE... [--build build]
Answer: along MH_01's own motion with things half a metre away all medians over four seeds are within a factor of 1.5 of
  the recording (docs/notebook/simulator_realism.md).
Date: 2026-11-21 to 2026-11-23.
"""

import argparse
import re
import subprocess
import sys
from pathlib import Path

FACTOR = 1.5
# name, whether it describes the images (and not the motion or the scene's brightness)
ROWS = [
    ("FAST corners per image", "fast_corners", True),
    ("cells of 40 px with a corner", "fast_cells", True),
    ("FAST response, median of cells", "fast_response", True),
    ("mean gradient, grey levels/px", "gradient", True),
    ("tracks per frame", "tracked", True),
    ("track life, mean, frames", "life", True),
    ("lost tracks per frame", "lost", True),
    ("found in the right image, %", "right", True),
    ("residual sigma, left, px", "sigma_left", True),
    ("residual sigma, right, px", "sigma_right", True),
    ("mean grey level", "grey", False),
    ("saturated pixels, %", "saturated_percent", False),
    ("right over left brightness", "right_over_left", False),
    ("rotation rate, rms, deg/s", "rate", False),
    ("speed, rms, m/s", "speed", False),
]


def run(arguments):
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"realism: {' '.join(map(str, arguments))} failed: {done.stderr.strip()}")
    return done.stdout


def column(text, name, index):
    match = re.search(rf"^\s*{re.escape(name)}\s+(.*)$", text, re.M)
    return float(match.group(1).split()[index])


def motion(sequence):
    """Root mean square of rotation rate and speed, from gyroscope and ground truth."""
    import numpy as np

    mav0 = Path(sequence) / "mav0"
    imu = np.genfromtxt(mav0 / "imu0" / "data.csv", delimiter=",", comments="#")
    rate = imu[:, 1:4] - np.median(imu[:, 1:4], axis=0)
    truth = np.genfromtxt(mav0 / "state_groundtruth_estimate0" / "data.csv", delimiter=",", comments="#")
    step = max(1, int(round(0.1 / np.median(np.diff(truth[:, 0] * 1e-9)))))
    thin = truth[::step]
    speed = np.diff(thin[:, 1:4], axis=0) / np.diff(thin[:, 0] * 1e-9)[:, None]
    return {"rate": float(np.degrees(np.sqrt((rate**2).sum(1).mean()))),
            "speed": float(np.sqrt((speed**2).sum(1).mean()))}


def figures(build, sequence, refine):
    values = {k: float(v) for k, v in re.findall(r"(\w+)=([-.\d]+)", run([build / "studies" / "image_statistics", sequence]))}
    # Recorded ground truth is too noisy to measure pixels with: the poses are fitted, in all sequences alike.
    report = run([build / "bench" / "frontend_report", sequence, "--refine-poses", str(refine)])
    values["tracked"] = column(report, "tracked", 1)
    values["lost"] = column(report, "lost", 1)
    values["life"] = column(report, "track life, frames", 1)
    values["right"] = column(report, "with right pixel, %", 1)
    for side in ("left", "right"):
        sigmas = [column(report, f"{side} {axis}", 2) for axis in "xy"]
        values[f"sigma_{side}"] = (sum(s * s for s in sigmas) / 2) ** 0.5
    values.update(motion(sequence))
    return values


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence")
    parser.add_argument("references", nargs="+")
    parser.add_argument("--build", default="build", type=Path, help="where the programs are")
    parser.add_argument("--refine-poses", default=100, type=int,
                        help="rounds; with few of them the noise of recorded ground truth stays in the residuals")
    arguments = parser.parse_args()
    names = [arguments.sequence, *arguments.references]
    table = [figures(arguments.build, name, arguments.refine_poses) for name in names]
    short = [Path(name).name[:20] for name in names]
    print(f"{'':32}" + "".join(f"{n:>21}" for n in short) + "".join(f"{'/ ' + n:>23}" for n in short[1:]))
    outside = 0
    for text, key, is_judged in ROWS:
        values = [t[key] for t in table]
        line = f"{text:32}" + "".join(f"{v:21.3f}" for v in values)
        for reference in values[1:]:
            ratio = values[0] / reference if reference else float("inf")
            bad = is_judged and not 1 / FACTOR <= ratio <= FACTOR
            outside += bad
            line += f"{ratio:21.2f}{' !' if bad else '  '}"
        print(line)
    print(f"{outside} ratios beyond a factor of {FACTOR}")


if __name__ == "__main__":
    main()
