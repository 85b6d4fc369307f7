"""Bags of a recording in the ASL layout, for the tests of the node: raw or compressed images, IMU, CameraInfo."""

import sys
from pathlib import Path

import rosbag
from PIL import Image as Picture
from rospy import Time
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, Imu

sys.path.append(str(Path(__file__).resolve().parents[2] / "src/facet/testing/robot"))
from asl_recording import CAMERAS, frames, rows, sensor

def time_of(stamp):
    return Time(stamp // 10**9, stamp % 10**9)


def raw_image(file):
    picture = Picture.open(file).convert("L")
    return Image(width=picture.width, height=picture.height, step=picture.width, encoding="mono8",
                 data=picture.tobytes())


def compressed_image(file):
    return CompressedImage(format=file.suffix[1:], data=file.read_bytes())


def imu_message(row):
    message = Imu()
    rate, force = message.angular_velocity, message.linear_acceleration
    rate.x, rate.y, rate.z, force.x, force.y, force.z = [float(value) for value in row[1:7]]
    return message


def camera_info(mav0, camera):
    values = sensor(mav0, camera)
    fx, fy, cx, cy = values["intrinsics"]
    width, height = values["resolution"]
    return CameraInfo(width=width, height=height, distortion_model="plumb_bob",
                      D=[*values["distortion_coefficients"], 0.0], K=[fx, 0, cx, 0, fy, cy, 0, 0, 1],
                      R=[1, 0, 0, 0, 1, 0, 0, 0, 1], P=[0] * 12)


def write_bag(sequence, out, seconds, make_image=raw_image, suffix="", change=None, with_info=False):
    """`change(camera, index, message)` may alter an image. Returns the stamps of the left images and of the IMU."""
    mav0 = Path(sequence) / "mav0"
    events = []
    for camera in CAMERAS:
        for index, (stamp, file) in enumerate(frames(mav0, camera, seconds)):
            events.append((stamp, camera, (index, file)))
    last = max(event[0] for event in events)
    events += [(int(row[0]), "imu0", row) for row in rows(mav0 / "imu0" / "data.csv") if int(row[0]) <= last + 2e8]
    infos = {camera: camera_info(mav0, camera) for camera in CAMERAS}
    with rosbag.Bag(str(out), "w") as bag:
        for stamp, name, what in sorted(events, key=lambda event: (event[0], event[1])):
            if name == "imu0":
                message, topic = imu_message(what), "/imu0"
            else:
                message, topic = make_image(what[1]), f"/{name}/image_raw{suffix}"
                if change:
                    change(name, what[0], message)
                if with_info:
                    infos[name].header.stamp = time_of(stamp)
                    bag.write(f"/{name}/camera_info", infos[name], time_of(stamp))
            message.header.stamp = time_of(stamp)
            message.header.frame_id = name
            bag.write(topic, message, time_of(stamp))
    return ([event[0] for event in sorted(events, key=lambda e: e[0]) if event[1] == "cam0"],
            sorted(event[0] for event in events if event[1] == "imu0"))
