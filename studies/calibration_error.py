#!/usr/bin/python3
"""Question: how far is EuRoC's calibration from its cameras? The calibration board of euroc_april_corners is placed into
  each stereo pair as well as it goes, and what is left is averaged by image region (8 x 5). Noise of the corners
  averages out, errors of the calibration stay.
Command: studies/calibration_error.py [DATA]
  DATA holds euroc_april_corners and euroc_mh01_handheld (default: $FACET_DATA_DIR, ../shared/data).
Answer: 0.139 px (left) and 0.124 px (right) rms per axis, which is what --lens-misfit adds and about what drawn calibrations
  carry (docs/simulator.md, docs/notebook/calibration_errors.md).
Date: 2026-11-21.
"""

import os
import re
import sys
from pathlib import Path

import numpy as np

COLUMNS, ROWS = 8, 5
SIZE = (752, 480)
MIN_CORNERS = 200


class Camera:
    def __init__(self, file):
        text = file.read_text()

        def numbers(key):
            return [float(x) for x in re.search(key + r"[^\[]*\[([^\]]*)\]", text).group(1).split(",") if x.strip()]

        self.T_BC = np.array(numbers("data")).reshape(4, 4)
        self.fx, self.fy, self.cx, self.cy = numbers("intrinsics")
        self.k1, self.k2, self.p1, self.p2 = numbers("distortion_coefficients")

    def project(self, p):
        x, y = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
        r = x * x + y * y
        d = 1 + self.k1 * r + self.k2 * r * r
        u = x * d + 2 * self.p1 * x * y + self.p2 * (r + 2 * x * x)
        v = y * d + self.p1 * (r + 2 * y * y) + 2 * self.p2 * x * y
        return np.stack([self.fx * u + self.cx, self.fy * v + self.cy], 1)


def exp_so3(w):
    angle = np.linalg.norm(w)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = w / angle
    hat = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * hat + (1 - np.cos(angle)) * hat @ hat


def rotation(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def place_board(cameras, R, t, views):
    """Gauss-Newton, robust, over the board's pose in the body; the residuals of each camera."""
    inverse = [np.linalg.inv(camera.T_BC) for camera in cameras]
    for _ in range(8):
        H, g, residuals = np.zeros((6, 6)), np.zeros(6), []
        for camera, T_CB, (points, pixels) in zip(cameras, inverse, views):
            def predict(R, t):
                return camera.project((points @ R.T + t) @ T_CB[:3, :3].T + T_CB[:3, 3])

            predicted = predict(R, t)
            r = predicted - pixels
            J = np.zeros((len(points), 2, 6))
            for j, e in enumerate(1e-6 * np.eye(6)):
                J[:, :, j] = (predict(exp_so3(e[:3]) @ R, t + e[3:]) - predicted) / 1e-6
            weight = 1 / (1 + (r**2).sum(1) / 0.25)
            H += np.einsum("nij,nik,n->jk", J, J, weight)
            g += np.einsum("nij,ni,n->j", J, r, weight)
            residuals.append(r)
        step = -np.linalg.solve(H, g)
        R, t = exp_so3(step[:3]) @ R, t + step[3:]
    return residuals


def main():
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("FACET_DATA_DIR", "../shared/data"))
    corners = data / "euroc_april_corners"
    if not corners.is_dir():
        sys.exit(f"calibration_error: no {corners}")
    cameras = [Camera(data / "euroc_mh01_handheld" / "mav0" / f"cam{c}" / "sensor.yaml") for c in (0, 1)]
    board = {(int(r[0]), int(r[1])): r[2:5] for r in np.genfromtxt(corners / "board.csv", delimiter=",", skip_header=1)}
    frames = [{}, {}]
    for c in (0, 1):
        with open(corners / f"cam{c}_corners.csv") as file:
            for line in file:
                if not line[0].isdigit():
                    continue
                stamp, tag, corner, u, v = line.split(",")
                points, pixels = frames[c].setdefault(int(stamp), ([], []))
                points.append(board[int(tag), int(corner)])
                pixels.append((float(u), float(v)))
    poses = np.genfromtxt(corners / "pnp_pose_of_body_in_board.tum", comments="#")
    found = [([], []), ([], [])]
    for stamp in sorted(set(frames[0]) & set(frames[1]))[::4]:
        pose = poses[np.argmin(abs(poses[:, 0] - stamp * 1e-9))]
        if abs(pose[0] - stamp * 1e-9) > 2e-3:
            continue
        R = rotation(pose[4:8]).T
        views = [tuple(np.array(x) for x in frames[c][stamp]) for c in (0, 1)]
        for c, r in enumerate(place_board(cameras, R, -R @ pose[1:4], views)):
            found[c][0].append(views[c][1])
            found[c][1].append(r)
    for c, name in enumerate(("left", "right")):
        pixels, residuals = np.concatenate(found[c][0]), np.concatenate(found[c][1])
        good = (abs(residuals) < 2).all(1)
        pixels, residuals = pixels[good], residuals[good]
        cell = np.minimum((pixels / SIZE * (COLUMNS, ROWS)).astype(int), (COLUMNS - 1, ROWS - 1))
        index = cell[:, 1] * COLUMNS + cell[:, 0]
        means = [np.median(residuals[index == i], 0) for i in range(COLUMNS * ROWS) if (index == i).sum() > MIN_CORNERS]
        rms = np.sqrt(np.mean(np.square(means), 0))
        print(f"{name}: {len(residuals)} corners, rms {residuals.std(0)[0]:.3f} {residuals.std(0)[1]:.3f} px (x, y); common to "
              f"an image region: {rms[0]:.3f} {rms[1]:.3f}, both axes {np.sqrt((rms**2).mean()):.3f} px, {len(means)} regions")


if __name__ == "__main__":
    main()
