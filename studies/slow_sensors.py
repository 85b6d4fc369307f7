#!/usr/bin/python3
"""Question: is a sensor noticed that goes wrong slowly, so that it contradicts the images at no moment, and how far do the
  biases of good sensors move by themselves?
Command: studies/slow_sensors.py plant FAULT IN OUT    copies IN to OUT with the fault; then facet run OUT and evaluate
         studies/slow_sensors.py drifts RESULT...      the largest change of a bias within 3 and 10 s, in units of what
                                                       its sigmas and its walk explain (BiasWatch's measure)
Answer: good sensors reach 3.1, slow faults 5 to 40; beyond 5 a run tells it (docs/notebook/faults.md, "Sensors that go
  wrong slowly").
Date: 2026-11-26.

IN is a recording in the EuRoC/ASL layout, times are seconds after its first left image. Results need the calibrated walks
of EuRoC's sensor (WALKS). Needs numpy (Debian: python3-numpy).
"""
import argparse
import csv
import shutil
import sys
from pathlib import Path

import numpy as np

WALKS = (1.9393e-5, 3e-3)  # of the gyroscope [rad/s^2/sqrt(Hz)] and of the accelerometer [m/s^3/sqrt(Hz)]
SPANS_S = (3, 10)


def creep(t, values, axis, change, seconds):
    values[:, axis] += change * np.clip((t - 4) / seconds, 0, 1)


def wander(t, values, size):
    for k in range(3, 6):
        values[:, k] += size * np.sin(2 * np.pi * (t - 3) / 10 + k + 1) * (t > 3)


def dead_axis(_, values):
    values[:, 4] = 0


def knock(t, values):
    """The IMU is turned by 2 deg about its z axis, from the eighth second on."""
    c, s = np.cos(np.radians(2)), np.sin(np.radians(2))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    for k in (0, 3):
        values[t > 8, k:k + 3] = values[t > 8, k:k + 3] @ turn.T


def low_pass(_, values):
    """First order, 100 ms at 200 Hz."""
    for i in range(1, len(values)):
        values[i, 3:] = values[i - 1, 3:] + 0.05 * (values[i, 3:] - values[i - 1, 3:])


FAULTS = {
    "creep": lambda t, v: creep(t, v, 4, 1.0, 10),
    "small-creep": lambda t, v: creep(t, v, 3, 0.4, 10),
    "wander": lambda t, v: wander(t, v, 0.25),
    "large-wander": lambda t, v: wander(t, v, 0.5),
    "dead-axis": dead_axis,
    "knock": knock,
    "low-pass": low_pass,
}


def plant(fault, source, out):
    if Path(out).exists():
        sys.exit(f"{out} is there already")
    shutil.copytree(source, out)
    mav = Path(out) / "mav0"
    file = mav / "imu0" / "data.csv"
    header = file.read_text().splitlines()[0]
    stamps = np.loadtxt(file, delimiter=",", usecols=0, dtype=np.int64)
    values = np.loadtxt(file, delimiter=",", usecols=range(1, 7))
    first = np.loadtxt(mav / "cam0" / "data.csv", delimiter=",", usecols=0, dtype=np.int64)[0]
    FAULTS[fault](1e-9 * (stamps - first), values)
    rows = [f"{stamp}," + ",".join(f"{x:.10g}" for x in row) for stamp, row in zip(stamps, values)]
    file.unlink()  # a copy of a read-only file is read-only, too
    file.write_text("\n".join([header, *rows]) + "\n")


def largest_drift(result, span_s):
    """Of the gyroscope and of the accelerometer, over all axes and frames."""
    with open(Path(result) / "states.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["px"]]
    t = np.array([int(row["timestamp_ns"]) for row in rows]) * 1e-9
    before = np.searchsorted(t, t - span_s)
    is_long_enough = t - t[0] > span_s
    largest = []
    for sensor, walk in zip(("bg", "ba"), WALKS):
        bias = np.array([[float(row[sensor + axis]) for axis in "xyz"] for row in rows])
        sigma = np.array([[float(row[f"sigma_{sensor}{axis}"]) for axis in "xyz"] for row in rows])
        explained = np.sqrt(sigma ** 2 + sigma[before] ** 2 + walk ** 2 * span_s)
        drift = np.abs(bias - bias[before]) / explained
        largest.append(drift[is_long_enough].max(initial=0))
    return largest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    planting = commands.add_parser("plant")
    planting.add_argument("fault", choices=FAULTS)
    planting.add_argument("source")
    planting.add_argument("out")
    commands.add_parser("drifts").add_argument("results", nargs="+")
    arguments = parser.parse_args()
    if arguments.command == "plant":
        plant(arguments.fault, arguments.source, arguments.out)
        return
    print("gyroscope, accelerometer within 3 s; within 10 s")
    for result in arguments.results:
        figures = ["%.1f, %.1f" % tuple(largest_drift(result, span_s)) for span_s in SPANS_S]
        print(f"{result}: {'; '.join(figures)}")


if __name__ == "__main__":
    main()
