"""A recording in the ASL layout, as the tests of the nodes send it."""

import csv

import numpy as np
import yaml

CAMERAS = ("cam0", "cam1")


def rows(file):
    with open(file, newline="") as stream:
        for row in csv.reader(stream):
            if row and not row[0].startswith("#"):
                yield row


def frames(mav0, camera, seconds):
    """(stamp, image file) of the first seconds."""
    found = [(int(row[0]), mav0 / camera / "data" / row[1].strip()) for row in rows(mav0 / camera / "data.csv")]
    return [frame for frame in found if frame[0] <= found[0][0] + seconds * 1e9]


def sensor(mav0, name):
    text = (mav0 / name / "sensor.yaml").read_text()
    return yaml.safe_load(text.split("\n", 1)[1] if text.startswith("%YAML") else text)


def pose_numbers(T):
    """x y z qx qy qz qw of a 4 x 4 matrix, whose rotation is less than half a turn."""
    R = T[:3, :3]
    w = np.sqrt(max(0.0, 1 + np.trace(R))) / 2
    x, y, z = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    return [float(v) for v in [*T[:3, 3], x / (4 * w), y / (4 * w), z / (4 * w), w]]


def mount(mav0):
    """T_imu_left and T_left_right, by EuRoC's sensor.yaml."""
    T_BC = [np.array(sensor(mav0, camera)["T_BS"]["data"]).reshape(4, 4) for camera in CAMERAS]
    return pose_numbers(T_BC[0]), pose_numbers(np.linalg.inv(T_BC[0]) @ T_BC[1])
