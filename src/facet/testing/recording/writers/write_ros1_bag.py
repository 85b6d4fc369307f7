#!/usr/bin/python3
"""write_ros1_bag.py SEQUENCE OUT.bag DURATION [none|bz2|lz4]: a ROS 1 bag by rosbag, the reference implementation.

PGM images become sensor_msgs/Image, all others sensor_msgs/CompressedImage. Exit code 77 where rosbag is missing
(Debian: python3-rosbag).
"""

import sys

from asl_folder import events, read_pgm

try:
    import rosbag
    from rospy import Time
    from sensor_msgs.msg import CompressedImage, Image, Imu
except ImportError as error:
    print(f"no rosbag for Python: {error}")
    sys.exit(77)

TOPICS = {"cam0": "/cam0/image_raw", "cam1": "/cam1/image_raw", "imu0": "/imu0"}


def image_message(content, suffix):
    pixels = read_pgm(content)
    if pixels is None:
        return CompressedImage(format=suffix, data=content), "/compressed"
    width, height, data = pixels
    return Image(width=width, height=height, encoding="mono8", step=width, data=data), ""


def main():
    sequence, out, duration_s = sys.argv[1], sys.argv[2], float(sys.argv[3])
    compression = sys.argv[4] if len(sys.argv) > 4 else "none"
    with rosbag.Bag(out, "w", compression=compression) as bag:
        for stamp, sensor, what in events(sequence, duration_s):
            suffix = ""
            if sensor == "imu0":
                message = Imu()
                rate, force = message.angular_velocity, message.linear_acceleration
                rate.x, rate.y, rate.z, force.x, force.y, force.z = what
            else:
                message, suffix = image_message(what.read_bytes(), what.suffix[1:])
            time = Time(stamp // 10**9, stamp % 10**9)
            message.header.stamp = time
            message.header.frame_id = sensor
            bag.write(TOPICS[sensor] + suffix, message, time)


if __name__ == "__main__":
    main()
