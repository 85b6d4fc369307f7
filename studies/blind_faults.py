#!/usr/bin/python3
"""Question: what becomes of a run under faults that nobody has built against? Plants one of ten (and a variant of one)
  in a recording in the EuRoC/ASL layout; they were thought out by somebody who knew none of those of src/facet/faults.
Command: studies/blind_faults.py FAULT IN OUT      copies IN to OUT with the fault in it; then facet run OUT and evaluate
         studies/blind_faults.py --list            names, magnitudes, and what a trustworthy system should do
Answer: five of ten ruined a run in silence (docs/notebook/faults.md, "A blind set of ten faults").
Date: 2026-11-25.

IN needs mav0/cam0, cam1, imu0; passing-panel, slow-panel and elevator also need mav0/state_groundtruth_estimate0.
Everything else is copied unchanged, so the truth stays true, and no fault touches the stamps of images. Times are
seconds after the first left image. Changed images are written as PNG under the stem of the old name. Needs numpy and
OpenCV (Debian: python3-numpy, python3-opencv).
"""
import argparse
import shutil
import sys
from pathlib import Path

import cv2
import numpy as np

FROM, TO = 6.0, 10.0        # most faults: from, to [s]


class Recording:
    """The files of a copy that is being damaged."""

    def __init__(self, root):
        self.mav = Path(root) / "mav0"
        self.header, self.rows, self.stamps, self.calibration = {}, {}, {}, {}
        for cam in ("cam0", "cam1"):
            lines = [line.strip() for line in (self.mav / cam / "data.csv").read_text().splitlines() if line.strip()]
            self.header[cam] = lines[0]
            self.rows[cam] = [[cell.strip() for cell in line.split(",")] for line in lines[1:]]
            self.stamps[cam] = np.array([int(row[0]) for row in self.rows[cam]])
            self.calibration[cam] = read_sensor(self.mav / cam / "sensor.yaml")
        self.t0 = self.stamps["cam0"][0]
        self.cache = {}

    def seconds(self, stamps):
        return (np.asarray(stamps, dtype=np.int64) - self.t0) * 1e-9

    def image(self, cam, index):
        """Image as recorded (never as damaged): the names in rows still are the old ones while a fault works."""
        key = (cam, index)
        if key not in self.cache:
            if len(self.cache) > 20:
                self.cache.clear()
            path = self.mav / cam / "data" / self.rows[cam][index][1]
            self.cache[key] = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
            if self.cache[key] is None:
                sys.exit(f"cannot read {path}")
        return self.cache[key]

    def change_images(self, cams, begin, end, change):
        """change(cam, index, seconds) returns the new image, or None to keep the old one."""
        for cam in cams:
            new = {}
            for index, t in enumerate(self.seconds(self.stamps[cam])):
                if begin <= t < end:
                    image = change(cam, index, t)
                    if image is not None:
                        name = Path(self.rows[cam][index][1]).stem + ".damaged.png"
                        cv2.imwrite(str(self.mav / cam / "data" / name), image, [cv2.IMWRITE_PNG_COMPRESSION, 1])
                        new[index] = name
            for index, name in new.items():
                (self.mav / cam / "data" / self.rows[cam][index][1]).unlink()
                self.rows[cam][index][1] = name.replace(".damaged", "")
                (self.mav / cam / "data" / name).rename(self.mav / cam / "data" / self.rows[cam][index][1])
            self.cache.clear()
            lines = [self.header[cam]] + [",".join(row) for row in self.rows[cam]]
            (self.mav / cam / "data.csv").write_text("\n".join(lines) + "\n")

    def change_imu(self, change):
        """change(stamps, seconds, values) returns stamps and values; values are w_x w_y w_z a_x a_y a_z."""
        path = self.mav / "imu0" / "data.csv"
        lines = [line.strip() for line in path.read_text().splitlines() if line.strip()]
        cells = [line.split(",") for line in lines[1:]]
        stamps = np.array([int(row[0]) for row in cells])
        values = np.array([[float(x) for x in row[1:7]] for row in cells])
        stamps, values = change(stamps, self.seconds(stamps), values)
        text = [f"{stamp}," + ",".join(f"{x:.10g}" for x in row) for stamp, row in zip(stamps, values)]
        path.write_text("\n".join([lines[0]] + text) + "\n")

    def truth(self):
        """stamps [ns], positions, rotations R_WB."""
        data = np.loadtxt(self.mav / "state_groundtruth_estimate0" / "data.csv", delimiter=",", comments="#")
        stamps = np.loadtxt(self.mav / "state_groundtruth_estimate0" / "data.csv", delimiter=",", comments="#",
                            usecols=0, dtype=np.int64)
        return stamps, data[:, 1:4], rotations(data[:, 4:8])


def read_sensor(path):
    """Intrinsics, distortion and T_BS of a camera's sensor.yaml, without a YAML library."""
    text = " ".join(line.split("#")[0] for line in path.read_text().splitlines())

    def numbers(key):
        after = text[text.index(key):]
        return np.array([float(x) for x in after[after.index("[") + 1:after.index("]")].split(",")])

    f = numbers("intrinsics:")
    return {"K": np.array([[f[0], 0, f[2]], [0, f[1], f[3]], [0, 0, 1]]),
            "D": numbers("distortion_coefficients:"), "T_BS": numbers("T_BS:").reshape(4, 4)}


def rotations(q):
    """Rotation matrices of quaternions (w x y z)."""
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    return np.stack([np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
                     np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
                     np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1)], -2)


def inside(t, begin=FROM, end=TO):
    return (t >= begin) & (t < end)


# ---- transport -------------------------------------------------------------------------------------------------------
def right_one_behind(rec):
    """The right camera's buffer queue slips by one: its images are those of one frame earlier (50 ms), stamps as if
    nothing had happened. 6 to 10 s."""
    rec.change_images(["cam1"], FROM, TO, lambda cam, i, t: rec.image(cam, i - 1).copy())


def tearing(rec):
    """DMA tearing: the lower part of both images still is that of the frame before; the tear wanders from row 25 % to
    row 75 % of the height and back every 2 s. 6 to 10 s."""
    def change(cam, i, t):
        image = rec.image(cam, i).copy()
        row = int(image.shape[0] * (0.5 + 0.25 * np.sin(2 * np.pi * (t - FROM) / 2.0)))
        image[row:] = rec.image(cam, i - 1)[row:]
        return image
    rec.change_images(["cam0", "cam1"], FROM, TO, change)


# ---- optics and camera settings --------------------------------------------------------------------------------------
def autofocus(rec):
    """Somebody left autofocus on: both lenses breathe. Both images are magnified about the principal point, by a ramp
    from 0 to 3 % (6 to 7.5 s), held (to 9 s), and back to 0 (at 10 s)."""
    def change(cam, i, t):
        s = 1 + 0.03 * min(1.0, (t - 6.0) / 1.5, (10.0 - t) / 1.0)
        K = rec.calibration[cam]["K"]
        A = np.array([[s, 0, (1 - s) * K[0, 2]], [0, s, (1 - s) * K[1, 2]]])
        image = rec.image(cam, i)
        return cv2.warpAffine(image, A, image.shape[::-1], flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    rec.change_images(["cam0", "cam1"], FROM, TO, change)


def roi_reset(rec):
    """Both camera drivers start over without a gap, and the sensors' region of interest is 24 px right of and 16 px
    below the calibrated one: the picture moves by (-24, -16) px in both cameras, from 8 s to the end. (The strip that
    the recording does not show repeats the border.)"""
    def change(cam, i, t):
        image = rec.image(cam, i)
        return cv2.copyMakeBorder(image[16:, 24:], 0, 16, 0, 24, cv2.BORDER_REPLICATE)
    rec.change_images(["cam0", "cam1"], 8.0, 1e9, change)


# ---- environment -----------------------------------------------------------------------------------------------------
def passing_panel(rec, width=1.8, speed=0.6, begin=5.0, end=11.0):
    """A lorry passes: a textured wall, 1.8 m wide and higher than the view, 1.5 m ahead of the left camera as it stands
    at 8 s, moves horizontally at 0.6 m/s and is in the middle at 8 s; from 5 to 11 s, in both cameras, rendered with
    calibration and true poses, in front of everything."""
    stamps, p, R = rec.truth()
    rng = np.random.default_rng(5)
    texture = np.zeros((1600, 1800), np.float32)                         # 1 px per mm, two more scales of blobs
    for size, weight in ((12, 0.3), (40, 0.4), (140, 0.3)):
        blobs = rng.random((1600 // size + 2, 1800 // size + 2)).astype(np.float32)
        blobs = cv2.resize(blobs, None, fx=size, fy=size, interpolation=cv2.INTER_NEAREST)
        texture += weight * blobs[:1600, :1800]
    texture = cv2.GaussianBlur(20 + 200 * texture, (0, 0), 1.5)

    def pose(stamp, cam):
        k = int(np.clip(np.searchsorted(stamps, stamp), 1, len(stamps) - 1))
        a = np.clip((stamp - stamps[k - 1]) / (stamps[k] - stamps[k - 1]), 0, 1)
        turn = cv2.Rodrigues(R[k - 1].T @ R[k])[0]
        T = np.eye(4)
        T[:3, :3] = R[k - 1] @ cv2.Rodrigues(turn * a)[0]
        T[:3, 3] = (1 - a) * p[k - 1] + a * p[k]
        return T @ rec.calibration[cam]["T_BS"]

    T_WP = pose(rec.t0 + int(8e9), "cam0") @ np.block([[np.eye(3), np.array([[0], [0], [1.5]])], [np.zeros(3), 1]])
    rays = {}

    def change(cam, i, t):
        image = rec.image(cam, i)
        h, w = image.shape
        if cam not in rays:
            u, v = np.meshgrid(np.arange(w, dtype=np.float64), np.arange(h, dtype=np.float64))
            c = rec.calibration[cam]
            xy = cv2.undistortPoints(np.stack([u, v], -1).reshape(-1, 1, 2), c["K"], c["D"]).reshape(h, w, 2)
            rays[cam] = np.concatenate([xy, np.ones((h, w, 1))], -1)
        T_PC = np.linalg.inv(T_WP) @ pose(int(rec.stamps[cam][i]), cam)  # camera in the frame of the panel
        d = rays[cam] @ T_PC[:3, :3].T
        along = -T_PC[2, 3] / np.where(np.abs(d[..., 2]) < 1e-6, 1e-6, d[..., 2])
        x = T_PC[0, 3] + along * d[..., 0] - speed * (t - 8.0) + width / 2     # the panel's own frame
        y = np.mod(T_PC[1, 3] + along * d[..., 1] + 0.8, 1.6)
        hit = (along > 0) & (x >= 0) & (x < width)
        paint = cv2.remap(texture, (x * 1000).astype(np.float32), (y * 1000).astype(np.float32), cv2.INTER_LINEAR,
                          borderMode=cv2.BORDER_REPLICATE)
        return np.where(hit, np.clip(paint, 0, 255), image).astype(np.uint8)
    rec.change_images(["cam0", "cam1"], begin, end, change)


def slow_panel(rec):
    """As passing-panel, but of a person's width and creeping: 0.6 m wide, 0.2 m/s, and there from the beginning to the
    end (in view when truth says so). Added after the first runs, to see how little is enough."""
    passing_panel(rec, 0.6, 0.2, 0.0, 1e9)


def elevator(rec):
    """The room is a lift: it speeds up with 1 m/s2 upwards (6 to 7.2 s), rides with 1.2 m/s, and slows down (8.8 to
    10 s). The cameras see nothing of it, the accelerometer does. The truth is that within the lift."""
    stamps, _, R = rec.truth()

    def change(imu_stamps, t, values):
        a = np.where(inside(t, 6.0, 7.2), 1.0, 0.0) - np.where(inside(t, 8.8, 10.0), 1.0, 0.0)
        k = np.clip(np.searchsorted(stamps, imu_stamps), 0, len(stamps) - 1)
        values[:, 3:6] += a[:, None] * R[k][:, 2, :]                     # third row of R_WB: the world's z in the body
        return imu_stamps, values
    rec.change_imu(change)


# ---- IMU and clock ---------------------------------------------------------------------------------------------------
def gyro_range(rec):
    """The IMU browns out and wakes up with its default range: counts are worth twice as much as the driver thinks,
    so all rates are reported at half their size. 7 to 9 s; no sample is missing."""
    def change(stamps, t, values):
        values[inside(t, 7.0, 9.0), 0:3] *= 0.5
        return stamps, values
    rec.change_imu(change)


def stuck_bit(rec):
    """Bit 6 of the rate about the body's x axis (the vertical one in EuRoC's rig) is stuck at 1: with 0.04 deg/s per
    count (ADIS16448) the rate is right, or 2.56 deg/s (0.0447 rad/s) too large. 6 to 10 s."""
    def change(stamps, t, values):
        lsb = np.deg2rad(0.04)
        counts = np.floor(values[:, 0] / lsb).astype(np.int64)
        values[:, 0] += np.where(inside(t) & ((counts & 64) == 0), 64 * lsb, 0.0)
        return stamps, values
    rec.change_imu(change)


def low_pass(rec):
    """A driver sets the IMU's low-pass filter to its slowest: all six channels go through two first-order filters of
    8 Hz: 40 ms late, and smooth; stamps as before. 6 to 10 s."""
    def change(stamps, t, values):
        dt = np.median(np.diff(t))
        k = 1 - np.exp(-2 * np.pi * 8.0 * dt)
        first = second = values[np.argmax(inside(t))].copy()
        out = values.copy()
        for i in np.nonzero(inside(t))[0]:
            first = first + k * (values[i] - first)
            second = second + k * (first - second)
            out[i] = second
        return stamps, out
    rec.change_imu(change)


def clock_slew(rec):
    """The IMU's hub is synchronised anew: its clock runs 1 % fast from 6 to 10 s, until its stamps are 40 ms late, and
    stays so to the end. No step, no hole; the cameras' clock (and that of the truth) is untouched."""
    def change(stamps, t, values):
        return stamps + np.round(1e9 * 0.01 * np.clip(t - FROM, 0, TO - FROM)).astype(np.int64), values
    rec.change_imu(change)


# name: (function, what a trustworthy system should do; written down before the first run)
FAULTS = {
    "right-one-behind": (right_one_behind, "go on with the left camera and the IMU: error <= 2 x; or warn that the "
                                           "right images do not fit"),
    "tearing": (tearing, "half of the corners are 50 ms late: error <= 2 x, or degraded / a warning"),
    "autofocus": (autofocus, "rates of gyro and image differ by 3 %: warn or larger sigmas; error <= 3 x"),
    "roi-reset": (roi_reset, "a jump of 3 deg that the gyro did not see, then a wrong mount: one new segment, a "
                             "warning, or degraded for good"),
    "passing-panel": (passing_panel, "believe the IMU, drop the corners on the panel; error <= 2 x, or degraded while "
                                     "it covers most of the view, with sigmas that grow"),
    "slow-panel": (slow_panel, "drop the corners on the panel (a fifth of the view): error <= 2 x"),
    "elevator": (elevator, "stay with the images (error within the lift <= 2 x), or say that IMU and images contradict "
                           "each other"),
    "gyro-range": (gyro_range, "images tell rotation much better: error <= 2 x, and a warning about the IMU"),
    "stuck-bit": (stuck_bit, "error <= 2 x, bias sigma reopened; a warning would be good"),
    "low-pass": (low_pass, "error <= 2 x; a warning that IMU and images contradict each other"),
    "clock-slew": (clock_slew, "estimate the offset (40 ms is far beyond 1 ms) or warn; error <= 2 x"),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="names, magnitudes and expectations")
    parser.add_argument("fault", nargs="?", choices=sorted(FAULTS), metavar="FAULT")
    parser.add_argument("source", nargs="?", metavar="IN")
    parser.add_argument("target", nargs="?", metavar="OUT")
    args = parser.parse_args()
    if args.list:
        for name, (function, expected) in FAULTS.items():
            print(f"{name}\n    {' '.join(function.__doc__.split())}\n    expected: {expected}")
        return
    if not args.target:
        parser.error("FAULT, IN and OUT are needed (or --list)")
    if Path(args.target).exists():
        sys.exit(f"{args.target} exists")
    shutil.copytree(args.source, args.target)
    FAULTS[args.fault][0](Recording(args.target))


if __name__ == "__main__":
    main()
