"""CDR (little-endian, as rosbag2 stores it) of the messages of a stereo-inertial recording, by struct alone."""

import struct


class Writer:
    def __init__(self):
        self.data = bytearray(b"\0\1\0\0")

    def number(self, kind, *values):
        size = struct.calcsize(kind)
        for value in values:
            self.data += bytes(-(len(self.data) - 4) % size)
            self.data += struct.pack("<" + kind, value)

    def text(self, text):
        encoded = text.encode() + b"\0"
        self.number("I", len(encoded))
        self.data += encoded

    def blob(self, content):
        self.number("I", len(content))
        self.data += content

    def header(self, stamp, frame):
        self.number("i", stamp // 10**9)
        self.number("I", stamp % 10**9)
        self.text(frame)


def image(stamp, frame, width, height, pixels):
    writer = Writer()
    writer.header(stamp, frame)
    writer.number("I", height, width)
    writer.text("mono8")
    writer.number("B", 0)
    writer.number("I", width)
    writer.blob(pixels)
    return bytes(writer.data)


def compressed_image(stamp, frame, kind, content):
    writer = Writer()
    writer.header(stamp, frame)
    writer.text(kind)
    writer.blob(content)
    return bytes(writer.data)


def imu(stamp, frame, six):
    writer = Writer()
    writer.header(stamp, frame)
    writer.number("d", 0, 0, 0, 1, *[0] * 9, *six[:3], *[0] * 9, *six[3:], *[0] * 9)
    return bytes(writer.data)
