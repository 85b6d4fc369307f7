#!/usr/bin/python3
"""Question: does a calibration that a flight refined describe the rig's lenses better or worse than the one it was given?
Command: studies/board_error.py CORNERS CALIBRATION...
  CORNERS: a folder with board.csv, cam0_corners.csv, cam1_corners.csv (detected corners of a known board). CALIBRATION:
  Kalibr's camchain-imucam.yaml or the calibration.yaml of a run. For every stamp with at least 20 corners in both images
  the pose of the board is fitted to both images together; printed is what is left, by a calibration of pinhole cameras
  with radial-tangential distortion and, if a run has written them, with what the lenses do beside that. --modes FILE
  takes these from another calibration.yaml.
Answer: the calibration.yaml of euroc_mh01_handheld against the given one: docs/notebook/calibration_online.md.
Date: 2026-11-28.
"""

import argparse
from pathlib import Path

import numpy as np
import yaml

LEAST_CORNERS = 20
ITERATIONS = 12


def read_corners(folder):
    """Per stamp, for both cameras, points of the board and pixels; stamps with enough corners in both images."""
    board = np.loadtxt(folder / "board.csv", delimiter=",", comments="#")
    place = {(int(row[0]), int(row[1])): row[2:5] for row in board}
    stamps = {}
    for k in range(2):
        for line in (folder / f"cam{k}_corners.csv").read_text().splitlines():
            if line and line[0].isdigit():
                stamp, tag, corner, u, v = line.split(",")
                views = stamps.setdefault(int(stamp), ([], []))
                views[k].append((*place[int(tag), int(corner)], float(u), float(v)))
    both = [tuple(np.array(view) for view in stamps[s]) for s in sorted(stamps)]
    return [views for views in both if min(map(len, views)) >= LEAST_CORNERS]


MONOMIALS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
EXPLAINED = [[(0, 0, 0, 1)], [(1, 0, 0, 1)], [(0, 1, 0, 1)], [(1, 0, 1, 1)], [(0, 0, 1, -1), (1, 1, 0, 1)],
             [(0, 2, 0, 1), (1, 1, 1, 1)], [(0, 1, 1, 1), (1, 0, 2, 1)], [(0, 2, 0, 1), (0, 0, 2, 1)],
             [(1, 2, 0, 1), (1, 0, 2, 1)], [(0, 3, 0, 1), (0, 1, 2, 1), (1, 2, 1, 1), (1, 0, 3, 1)]]
REST = [[(0, 0, 1, 1), (1, 1, 0, 1)],
        *([(0, *powers, 1)] for powers in [(0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]),
        *([(1, *powers, 1)] for powers in [(2, 0), (3, 0), (2, 1), (1, 2)])]


class Modes:
    """What a lens does beside its model (docs/math.md, section 10.9): coefficients of the monomials by axis."""

    def __init__(self, amounts, size):
        width, height = size
        self.scale, aspect = np.array([2 / (width - 1), 2 / (height - 1)]), (height - 1) / (width - 1)
        fields = np.zeros((20, 20))
        for k, terms in enumerate(EXPLAINED + REST):
            for axis, i, j, factor in terms:
                fields[10 * axis + MONOMIALS.index((i, j)), k] = factor * aspect**j
        mean = lambda n: 0 if n % 2 else 1 / (n + 1)  # noqa: E731
        moments = np.kron(np.eye(2), [[mean(a + c) * mean(b + d) for c, d in MONOMIALS] for a, b in MONOMIALS])
        L = np.linalg.cholesky(fields.T @ moments @ fields)
        modes = np.sqrt(2) * np.linalg.solve(L, fields.T)[10:]
        self.coefficients = (np.array(amounts) @ modes).reshape(2, 10).T

    def at(self, px):
        x, y = (px * self.scale - 1).T
        return np.stack([x**i * y**j for i, j in MONOMIALS], 1) @ self.coefficients


class Camera:
    def __init__(self, node):
        if node["camera_model"] != "pinhole" or node["distortion_model"] != "radtan":
            raise SystemExit("board_error: pinhole cameras with radtan distortion only")
        self.f, self.c = np.split(np.array(node["intrinsics"], float), 2)
        self.d = np.array(node["distortion_coeffs"], float)
        self.T_CB = np.array(node["T_cam_imu"], float)
        self.beside_model = Modes(node.get("lens_modes", np.zeros(10)), node["resolution"])

    def project(self, p_C):
        x, y = p_C[:, 0] / p_C[:, 2], p_C[:, 1] / p_C[:, 2]
        k1, k2, p1, p2 = self.d
        r2 = x * x + y * y
        radial = 1 + k1 * r2 + k2 * r2 * r2
        u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        px = self.f * np.stack([u, v], 1) + self.c
        return px + self.beside_model.at(px)


def exponential(w):
    angle = np.linalg.norm(w)
    W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    if angle < 1e-9:
        return np.eye(3) + W
    return np.eye(3) + np.sin(angle) / angle * W + (1 - np.cos(angle)) / angle**2 * W @ W


def residuals(R, p, views, cameras, T_CL):
    """Pixels, of both images one after the other; R, p: board to left camera."""
    out = []
    for view, camera, (R_CL, p_CL) in zip(views, cameras, T_CL):
        p_C = (view[:, :3] @ R.T + p) @ R_CL.T + p_CL
        out.append(camera.project(p_C) - view[:, 3:])
    return np.concatenate(out)


def first_pose(view, camera):
    """From the homography of the left view, distortion taken off to first order."""
    m = (view[:, 3:] - camera.c) / camera.f
    for _ in range(10):
        ideal = camera.project(np.column_stack([m, np.ones(len(m))]))
        m = m + (view[:, 3:] - ideal) / camera.f
    rows = []
    for (X, Y, _), (x, y) in zip(view[:, :3], m):
        rows += [[X, Y, 1, 0, 0, 0, -x * X, -x * Y, -x], [0, 0, 0, X, Y, 1, -y * X, -y * Y, -y]]
    H = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
    H /= np.sqrt(np.linalg.norm(H[:, 0]) * np.linalg.norm(H[:, 1])) * np.sign(H[2, 2])
    U, _, Vt = np.linalg.svd(np.column_stack([H[:, 0], H[:, 1], np.cross(H[:, 0], H[:, 1])]))
    return U @ Vt, H[:, 2]


def fit(views, cameras, T_CL):
    R, p = first_pose(views[0], cameras[0])
    for _ in range(ITERATIONS):
        r = residuals(R, p, views, cameras, T_CL).ravel()
        J, step = np.empty((len(r), 6)), 1e-6
        for k in range(6):
            delta = step * np.eye(6)[k]
            J[:, k] = (residuals(exponential(delta[:3]) @ R, p + delta[3:], views, cameras, T_CL).ravel() - r) / step
        weights = np.minimum(1, 1.5 / np.maximum(np.abs(r), 1e-9))  # a misread corner counts less
        delta = -np.linalg.lstsq(J * np.sqrt(weights)[:, None], r * np.sqrt(weights), rcond=None)[0]
        R, p = exponential(delta[:3]) @ R, p + delta[3:]
        if np.linalg.norm(delta) < 1e-9:
            break
    return residuals(R, p, views, cameras, T_CL)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("corners", type=Path)
    parser.add_argument("calibrations", type=Path, nargs="+")
    parser.add_argument("--modes", type=Path)
    args = parser.parse_args()
    stamps = read_corners(args.corners)
    print("| calibration | stamps | rms [px] | left | right | median of a corner's error [px] |\n|---|---|---|---|---|---|")
    for path in args.calibrations:
        chain = yaml.safe_load(path.read_text())
        if args.modes:
            other = yaml.safe_load(args.modes.read_text())
            for name in ("cam0", "cam1"):
                chain[name]["lens_modes"] = other[name]["lens_modes"]
        cameras = [Camera(chain["cam0"]), Camera(chain["cam1"])]
        T_RL = cameras[1].T_CB @ np.linalg.inv(cameras[0].T_CB)
        T_CL = [(np.eye(3), np.zeros(3)), (T_RL[:3, :3], T_RL[:3, 3])]
        sides, sizes = np.zeros((2, 2)), []
        for views in stamps:
            r = fit(views, cameras, T_CL)
            for k, part in enumerate(np.split(r, [len(views[0])])):
                sides[k] += (part**2).sum(), part.size
            sizes.extend(np.linalg.norm(r, axis=1))
        rms = np.sqrt(sides[:, 0] / sides[:, 1])
        both = np.sqrt(sides[:, 0].sum() / sides[:, 1].sum())
        name = f"{path.parent.name}/{path.name}" + (", modes of the other" if args.modes else "")
        print(f"| {name} | {len(stamps)} | {both:.3f} | {rms[0]:.3f} | {rms[1]:.3f} | "
              f"{np.median(sizes):.3f} |", flush=True)


if __name__ == "__main__":
    main()
