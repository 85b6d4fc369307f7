#!/usr/bin/python3
"""Question: does the estimator believe that it has learnt what a motion cannot show? At constant velocity a wrong
  disparity looks like a bias, a hover shows no scale, a turn about one axis neither the cameras' place nor the others'
  scales. NEES of the states and of the calibration, whose errors are drawn anew for each run.
Command: studies/motion_nees.py [--program build/facet] [--out runs/motion_nees] [--draws 8]
  Renders four flights of half a minute through `room` once, then draws calibrations for each.
Answer: docs/notebook/calibration_online.md, "What a motion cannot show".
Date: 2026-11-27.
"""

import argparse
import json
import math
import statistics
import subprocess
from pathlib import Path

DURATION_S, RATE_HZ = 30, 200
REST_S = 2.0  # before a motion that is made up here begins
HEADER = "#timestamp [ns], p_x, p_y, p_z [m], q_w, q_x, q_y, q_z\n"
FORWARD = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))  # w x y z: the cameras look along x, x of the body is up


def times(a, b):
    """Product of quaternions."""
    w, x, y, z = b
    return (a[0] * w - a[1] * x - a[2] * y - a[3] * z, a[0] * x + a[1] * w + a[2] * z - a[3] * y,
            a[0] * y - a[1] * z + a[2] * w + a[3] * x, a[0] * z + a[1] * y - a[2] * x + a[3] * w)


def at_constant_velocity(t):
    """0.2 m/s along x, which are reached within two seconds."""
    speed, ramp_s = 0.2, 2.0
    s = max(0.0, t - REST_S)
    x = speed * (s * s / (2 * ramp_s) if s < ramp_s else s - ramp_s / 2)
    return (x - 2.5, 0, 1.3), FORWARD


def turning_about_z(t):
    """To and fro by 60 deg in six seconds, on the spot."""
    s = max(0.0, t - REST_S)
    yaw = math.radians(60) * (1 - math.cos(2 * math.pi * s / 6)) / 2
    return (0, 0, 1.3), times((math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)), FORWARD)


MOTIONS = {"constant velocity": at_constant_velocity, "hover": "hover", "turn about one axis": turning_about_z,
           "all axes": "fast"}


def write_path(pose_at, file):
    with open(file, "w", encoding="utf-8") as stream:
        stream.write(HEADER)
        for i in range((DURATION_S + 1) * RATE_HZ):  # some of its end is needed for the spline
            p, q = pose_at(i / RATE_HZ)
            stream.write(f"{10**18 + i * 10**9 // RATE_HZ}," + ",".join(f"{value:.9f}" for value in (*p, *q)) + "\n")
    return file


def rendered(program, out, name, motion):
    sequence = out / "sequences" / name.replace(" ", "-")
    if not (sequence / "simulation.txt").exists():
        sequence.parent.mkdir(parents=True, exist_ok=True)
        path = motion if isinstance(motion, str) else write_path(motion, out / f"{sequence.name}.csv")
        subprocess.run([program, "simulate", "--quiet", "--out", sequence, "--trajectory", path, "--duration",
                        str(DURATION_S), "--seed", "51", "--set", "image.rays_per_pixel=3"], check=True)
    return sequence


def evaluated(program, out, sequence, draw):
    """The run with a drawn calibration, as `facet evaluate` judges it."""
    copy = out / "drawn" / f"{sequence.name}-{draw}"
    result = out / "runs" / copy.name
    if not (copy / "simulation.txt").exists():
        subprocess.run([program, "simulate", "--quiet", "--of", sequence, "--draw-calibration", str(draw), "--out",
                        copy], check=True)
    subprocess.run([program, "run", copy, "--quiet", "--set", "mesh.map.enabled=false", "--out", result], check=True,
                   capture_output=True)
    subprocess.run([program, "evaluate", result, "--truth", copy, "--parts", "consistency"], check=True,
                   capture_output=True)
    return json.loads((result / "evaluation.json").read_text(encoding="utf-8"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/facet")
    parser.add_argument("--out", type=Path, default=Path("runs/motion_nees"))
    parser.add_argument("--draws", type=int, default=8)
    arguments = parser.parse_args()
    print("| motion | ATE [mm], median | position NEES | orientation | velocity | gyroscope's bias | accelerometer's "
          "bias | calibration |\n|---|---|---|---|---|---|---|---|")
    for name, motion in MOTIONS.items():
        sequence = rendered(arguments.program, arguments.out, name, motion)
        runs = [evaluated(arguments.program, arguments.out, sequence, draw) for draw in range(1, arguments.draws + 1)]
        ate = 1e3 * statistics.median(run["ate"]["rmse_m"] for run in runs)
        cells = [statistics.mean(run["consistency"][part]["nees"] for run in runs)
                 for part in ("position", "orientation", "velocity", "gyro_bias", "accelerometer_bias")]
        cells.append(statistics.mean(run["calibration"]["nees"] for run in runs))
        print(f"| {name} | {ate:.1f} | " + " | ".join(f"{cell:.2f}" for cell in cells) + " |", flush=True)


if __name__ == "__main__":
    main()
