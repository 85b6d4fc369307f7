#!/usr/bin/python3
"""Trajectory errors in the most literal way, to check `facet evaluate` against (a test runs both).

Shares no code with the C++ implementation and prefers obvious loops to speed. Prints JSON:
  naive_ate.py ESTIMATE TRUTH [--lengths 1 2 5] [--alignment se3|yaw|sim3] [--time-offset-ns N]
Both files: TUM (seconds, quaternion xyzw) or EuRoC csv (nanoseconds, quaternion wxyz).
"""

import argparse
import json
import re
import sys
from decimal import Decimal

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np


def read_trajectory(path):
    """Stamps [ns, int], positions (n,3), quaternions wxyz (n,4); of equal stamps the first is kept."""
    poses = {}
    for line in open(path, encoding="utf-8"):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        words = re.split(r"[,\s]+", line)
        numbers = [float(w) for w in words[1:8]]
        if "," in line:
            stamp, q = int(words[0]), numbers[3:7]
        else:
            stamp, q = int((Decimal(words[0]) * 10**9).to_integral_value()), numbers[6:7] + numbers[3:6]
        poses.setdefault(stamp, (numbers[0:3], q))
    stamps = sorted(poses)
    p = np.array([poses[t][0] for t in stamps])
    q = np.array([poses[t][1] for t in stamps])
    return stamps, p, q / np.linalg.norm(q, axis=1)[:, None]


def slerp(a, b, s):
    cosine = float(a @ b)
    if cosine < 0:
        b, cosine = -b, -cosine
    angle = np.arccos(min(1.0, cosine))
    if np.sin(angle) < 1e-12:
        q = (1 - s) * a + s * b
    else:
        q = (np.sin((1 - s) * angle) * a + np.sin(s * angle) * b) / np.sin(angle)
    return q / np.linalg.norm(q)


def rotation(q):
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def associate(estimate, truth):
    """Truth interpolated at the estimate's stamps; never beyond its ends nor across a hole in it."""
    stamps, p, q = estimate
    t, p_true, q_true = truth
    max_gap = max(100_000_000, 3 * int(np.median(np.diff(t))))
    rows = []
    for stamp, position, orientation in zip(stamps, p, q):
        after = int(np.searchsorted(t, stamp))
        if after < len(t) and t[after] == stamp:
            rows.append((stamp, position, orientation, p_true[after], q_true[after]))
        elif 0 < after < len(t) and t[after] - t[after - 1] <= max_gap:
            s = (stamp - t[after - 1]) / (t[after] - t[after - 1])
            p_at = (1 - s) * p_true[after - 1] + s * p_true[after]
            rows.append((stamp, position, orientation, p_at, slerp(q_true[after - 1], q_true[after], s)))
    return rows


def align(p, g, with_scale=False):
    """Rotation, scale, translation with g ~ scale R p + t (Umeyama 1991)."""
    mean_p, mean_g = p.mean(axis=0), g.mean(axis=0)
    cross = (g - mean_g).T @ (p - mean_p)
    u, d, vt = np.linalg.svd(cross)
    s = np.diag([1, 1, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    R = u @ s @ vt
    scale = np.trace(np.diag(d) @ s) / ((p - mean_p) ** 2).sum() if with_scale else 1.0
    return R, scale, mean_g - scale * R @ mean_p


def align_yaw(p, g):
    """Rotation about z only: the heading of complex numbers x + iy."""
    mean_p, mean_g = p.mean(axis=0), g.mean(axis=0)
    from_p = (p - mean_p)[:, 0] + 1j * (p - mean_p)[:, 1]
    to_g = (g - mean_g)[:, 0] + 1j * (g - mean_g)[:, 1]
    turn = np.sum(to_g * np.conj(from_p))
    turn /= abs(turn)
    R = np.array([[turn.real, -turn.imag, 0], [turn.imag, turn.real, 0], [0, 0, 1]])
    return R, 1.0, mean_g - R @ mean_p


def statistics(errors):
    return {
        "rmse": float(np.sqrt(np.mean(np.square(errors)))),
        "median": float(np.median(errors)),
        "mean": float(np.mean(errors)),
        "max": float(np.max(errors)),
    }


def absolute_errors(rows, alignment="se3"):
    p = np.array([r[1] for r in rows])
    g = np.array([r[3] for r in rows])
    R, scale, t = align_yaw(p, g) if alignment == "yaw" else align(p, g, alignment == "sim3")
    return np.linalg.norm(g - (scale * (R @ p.T).T + t), axis=1)


def matrix(p, q):
    T = np.eye(4)
    T[:3, :3] = rotation(q)
    T[:3, 3] = p
    return T


def relative_errors(rows, length):
    """Errors over pairs whose truth is `length` of path apart, within one percent."""
    estimate = [matrix(r[1], r[2]) for r in rows]
    truth = [matrix(r[3], r[4]) for r in rows]
    steps = [np.linalg.norm(rows[k][3] - rows[k - 1][3]) for k in range(1, len(rows))]
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    translations, angles = [], []
    for i in range(len(rows) - 1):
        difference = np.abs(travelled[i + 1:] - (travelled[i] + length))
        j = i + 1 + int(np.argmin(difference))
        if difference[j - i - 1] > 0.01 * length:
            continue
        P = np.linalg.inv(estimate[i]) @ estimate[j]
        G = np.linalg.inv(truth[i]) @ truth[j]
        E = np.linalg.inv(P) @ G
        translations.append(np.linalg.norm(E[:3, 3]))
        # sin and cos of the angle from the antisymmetric part and the trace
        sine = 0.5 * np.linalg.norm([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]])
        angles.append(np.degrees(np.arctan2(sine, 0.5 * (np.trace(E[:3, :3]) - 1))))
    return np.array(translations), np.array(angles)


def evaluate(estimate_path, truth_path, lengths, alignment="se3", time_offset_ns=0):
    stamps, p, q = read_trajectory(estimate_path)
    rows = associate(([t + time_offset_ns for t in stamps], p, q), read_trajectory(truth_path))
    if len(rows) < 3:
        sys.exit("naive_ate: fewer than 3 poses have a truth")
    _, scale, _ = align(np.array([r[1] for r in rows]), np.array([r[3] for r in rows]), True)
    rpe = []
    relative = []
    for length in lengths:
        translations, angles = relative_errors(rows, length)
        if len(translations) == 0:
            continue
        relative += list(translations / length)
        rpe.append({
            "length_m": length,
            "pairs": len(translations),
            "translation_median_m": float(np.median(translations)),
            "translation_rmse_m": statistics(translations)["rmse"],
            "rotation_median_deg": float(np.median(angles)),
            "rotation_rmse_deg": statistics(angles)["rmse"],
        })
    return {
        "poses": len(rows),
        "ate": {f"{k}_m": v for k, v in statistics(absolute_errors(rows, alignment)).items()},
        "rpe": rpe,
        "drift_percent": 100 * float(np.mean(relative)) if relative else None,
        "scale_error_percent": 100 * (1 / scale - 1),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("estimate")
    parser.add_argument("truth")
    parser.add_argument("--lengths", type=float, nargs="*", default=[1, 2, 5, 10, 20])
    parser.add_argument("--alignment", choices=["se3", "yaw", "sim3"], default="se3")
    parser.add_argument("--time-offset-ns", type=int, default=0)
    arguments = parser.parse_args()
    json.dump(evaluate(arguments.estimate, arguments.truth, arguments.lengths, arguments.alignment,
                       arguments.time_offset_ns), sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
