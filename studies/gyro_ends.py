#!/usr/bin/python3
"""Question: is the gyroscope's error between two frames white noise of the calibrated density? And would a gyroscope
whose error is just that make the estimate better?
Command: studies/gyro_ends.py SEQUENCE [--interval S] [--write OUT]
  Rates are integrated between true orientations that are S seconds apart, with the true biases. Printed by axis: the
  standard deviation of the difference over that of white noise, and the correlation of neighbouring intervals (-0.5:
  each end of an interval is off by itself, however long it is). --write: the sequence with true mean rates and white
  noise of the calibrated density in place of the gyroscope's, images as links.
Answer: 2 to 7 times the noise over 0.25 s with a correlation of -0.3 to -0.6, which is vibration that the true
  orientations do not have; without it the ATE is as it was (docs/notebook/calibration_online.md).
Date: 2026-11-25.
"""

import argparse
import os
import re
import shutil
from pathlib import Path

import numpy as np

from truth_lag import read, rotations

NOISE_SEED = 1


def log(R):
    angle = np.arccos(np.clip((np.trace(R, axis1=1, axis2=2) - 1) / 2, -1, 1))
    axis = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], 1) / 2
    factor = np.where(angle < 1e-9, 1, angle / np.maximum(np.sin(angle), 1e-12))
    return axis * factor[:, None]


def exp(v):
    angle = np.linalg.norm(v)
    x, y, z = v / max(angle, 1e-12)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def density(imu_folder):
    text = (imu_folder / "sensor.yaml").read_text(encoding="utf-8")
    return float(re.search(r"gyroscope_noise_density:\s*([-+.\deE]+)", text).group(1))


def differences(t, gyro, R, bias, interval_s):
    """Integrated against true, one row for each interval."""
    steps = np.maximum(1, np.round(interval_s / np.median(np.diff(t)))).astype(int)
    rows = []
    for begin in range(0, len(t) - steps, steps):
        turned = np.eye(3)
        for k in range(begin, begin + steps):
            turned = turned @ exp((0.5 * (gyro[k] + gyro[k + 1]) - bias[begin]) * (t[k + 1] - t[k]))
        rows.append(turned.T @ R[begin].T @ R[begin + steps])
    return log(np.array(rows))


def write(source, out, imu, kept, truth_rates, bias, sigma):
    """A copy with the rates at the stamps that have a true orientation replaced."""
    shutil.copytree(source, out, symlinks=True, ignore=shutil.ignore_patterns("cam0", "cam1"))
    for camera in ("cam0", "cam1"):
        os.symlink((source / "mav0" / camera).resolve(), out / "mav0" / camera)
    file = out / "mav0" / "imu0" / "data.csv"
    lines = file.read_text(encoding="utf-8").splitlines()
    header = [line for line in lines if line.startswith("#")]
    stamps = [line.split(",")[0] for line in lines if not line.startswith("#")]
    # At a sample: the mean of the true rates before and after it.
    at_sample = np.vstack([truth_rates[:1], 0.5 * (truth_rates[1:] + truth_rates[:-1]), truth_rates[-1:]])
    noise = np.random.default_rng(NOISE_SEED).normal(size=at_sample.shape) * sigma
    values = imu[:, 1:7].copy()
    values[kept, :3] = at_sample + bias + noise
    rows = [stamp + "," + ",".join(f"{v:.9f}" for v in row) for stamp, row in zip(stamps, values)]
    file.write_text("\n".join(header + rows) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", type=Path)
    parser.add_argument("--interval", type=float, default=0.25, help="seconds")
    parser.add_argument("--write", type=Path)
    arguments = parser.parse_args()
    mav0 = arguments.sequence / "mav0"
    imu, truth = read(mav0 / "imu0" / "data.csv"), read(mav0 / "state_groundtruth_estimate0" / "data.csv")
    _, kept, of_truth = np.intersect1d(imu[:, 0], truth[:, 0], return_indices=True)
    if len(kept) < 3:
        raise SystemExit("gyro_ends: the true orientations have none of the IMU's stamps")
    t = (imu[kept, 0] - imu[kept[0], 0]) / 1e9
    R, bias = rotations(truth[of_truth, 4:8]), truth[of_truth, 11:14]
    noise = density(mav0 / "imu0")
    error = differences(t, imu[kept, 1:4], R, bias, arguments.interval)
    ratio = error.std(0) / (noise * np.sqrt(arguments.interval))
    correlation = [np.corrcoef(error[1:, k], error[:-1, k])[0, 1] for k in range(3)]
    print(f"{len(error)} intervals of {arguments.interval:g} s, axes x y z")
    print("difference over white noise:      " + " ".join(f"{v:6.2f}" for v in ratio))
    print("correlation of neighbours:        " + " ".join(f"{v:6.2f}" for v in correlation))
    if arguments.write:
        rates = log(R[:-1].transpose(0, 2, 1) @ R[1:]) / np.diff(t)[:, None]
        write(arguments.sequence, arguments.write, imu, kept, rates, bias, noise / np.sqrt(np.median(np.diff(t))))


if __name__ == "__main__":
    main()
