#!/usr/bin/python3
"""Question: do the positions of a recorded ground truth belong to its stamps? A tracker of positions has a clock of its own.
Command: studies/truth_lag.py SEQUENCE [--late MS --write truth.csv]
  No estimate is used: second differences of the true positions over +-T are compared with the same filter on the IMU,
  turned by the true orientation. Where the truth is a fit to IMU and tracker, short T show the IMU's clock and long T the
  tracker's. --write: the truth with its positions MS earlier, for `facet evaluate RUN --truth truth.csv`.
Answer: those of euroc_mh01_handheld are some 8 ms late over a second and 0 over 0.1 s (docs/notebook/figures.md).
Date: 2026-11-25.
"""

import argparse
from pathlib import Path

import numpy as np

HALF_WIDTHS_S = [0.05, 0.1, 0.2, 0.3, 0.4, 0.6]
LAGS_S = np.arange(-20, 20.5, 0.5) / 1e3
MARGIN_S = 0.3


def read(file):
    return np.genfromtxt(file, delimiter=",", comments="#")


def rotations(q):
    w, x, y, z = q.T
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return np.array(rows).transpose(2, 0, 1)


def at(times, values, t):
    return np.stack([np.interp(t, times, column) for column in values.T], 1)


def integral(times, values):
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(times)[:, None]
    return np.vstack([np.zeros(values.shape[1]), np.cumsum(steps, 0)])


def second_difference(times, values, t, half_s):
    before, here, after = (at(times, values, t + shift) for shift in (-half_s, 0, half_s))
    return (after - 2 * here + before) / half_s**2


def lag_s(truth, imu, half_s):
    """How late the positions are against the IMU; what is left of the accelerations then, and without a lag [m/s^2]."""
    begin = truth[0, 0]
    t_truth, t_imu = (1e-9 * (data[:, 0] - begin) for data in (truth, imu))
    near = np.clip(np.searchsorted(t_truth, t_imu), 0, len(truth) - 1)
    R = rotations(truth[near, 4:8])
    columns = np.concatenate([np.einsum("nij,nj->ni", R, imu[:, 4:7])[:, :, None], R], 2)  # acceleration, biases
    twice = integral(t_imu, integral(t_imu, columns.reshape(len(imu), 12)))
    margin = half_s + MARGIN_S
    t = t_truth[(t_truth > margin) & (t_truth < min(t_truth[-1], t_imu[-1]) - margin)]
    measured = second_difference(t_truth, truth[:, 1:4], t, half_s)

    def left_over(lag):
        filtered = second_difference(t_imu, twice, t - lag, half_s).reshape(len(t), 3, 4)
        errors = (measured - filtered[:, :, 0]).ravel()
        unknown = np.concatenate([filtered[:, :, 1:], np.broadcast_to(np.eye(3), (len(t), 3, 3))], 2).reshape(-1, 6)
        weights = np.ones(len(errors))
        for _ in range(5):  # robust: the truth has steps
            x = np.linalg.lstsq(weights[:, None] * unknown, weights * errors, rcond=None)[0]
            left = errors - unknown @ x
            weights = 1 / np.hypot(1, left / (2 * np.median(np.abs(left))))
        return np.sqrt(np.median(left**2))

    costs = [left_over(lag) for lag in LAGS_S]
    return LAGS_S[int(np.argmin(costs))], min(costs), left_over(0)


def write_moved(truth, lines, late_s, file):
    moved = at(truth[:, 0], truth[:, 1:4], truth[:, 0] + 1e9 * late_s)
    with open(file, "w", encoding="utf-8") as out:
        rows = iter(moved)
        for line in lines:
            if not line.startswith("#"):
                cells = line.split(",")
                cells[1:4] = [f"{value:.6f}" for value in next(rows)]
                line = ",".join(cells)
            out.write(line)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", type=Path)
    parser.add_argument("--late", type=float, default=0, metavar="MS")
    parser.add_argument("--write", type=Path)
    arguments = parser.parse_args()
    mav0 = arguments.sequence / "mav0"
    file = mav0 / "state_groundtruth_estimate0" / "data.csv"
    truth, imu = read(file), read(mav0 / "imu0" / "data.csv")
    if arguments.write:
        write_moved(truth, file.read_text(encoding="utf-8").splitlines(keepends=True), arguments.late / 1e3,
                    arguments.write)
        return
    for half_s in HALF_WIDTHS_S:
        lag, least, without = lag_s(truth, imu, half_s)
        print(f"+-{half_s:.2f} s: positions {1e3 * lag:4.1f} ms late, {least:.4f} m/s^2 left ({without:.4f} without)")


if __name__ == "__main__":
    main()
