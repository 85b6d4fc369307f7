"""Messages of ROS 2 and their bytes (CDR, little-endian), by their definitions and struct alone: neither the code under
test nor Cyclone DDS. `dds/test/decode.mjs` checks this against another codec and ROS 2's own definitions."""

import struct

# Of common_interfaces, rcl_interfaces and geometry2 in Humble. "[]" has a length before it, "[9]" has not.
DEFINITIONS = {
    "std_msgs/msg/Header": "time stamp; string frame_id",
    "std_msgs/msg/ColorRGBA": "float32 r; float32 g; float32 b; float32 a",
    "geometry_msgs/msg/Vector3": "float64 x; float64 y; float64 z",
    "geometry_msgs/msg/Point": "float64 x; float64 y; float64 z",
    "geometry_msgs/msg/Quaternion": "float64 x; float64 y; float64 z; float64 w",
    "geometry_msgs/msg/Pose": "geometry_msgs/msg/Point position; geometry_msgs/msg/Quaternion orientation",
    "geometry_msgs/msg/PoseStamped": "std_msgs/msg/Header header; geometry_msgs/msg/Pose pose",
    "geometry_msgs/msg/PoseWithCovariance": "geometry_msgs/msg/Pose pose; float64[36] covariance",
    "geometry_msgs/msg/PoseWithCovarianceStamped":
        "std_msgs/msg/Header header; geometry_msgs/msg/PoseWithCovariance pose",
    "geometry_msgs/msg/Twist": "geometry_msgs/msg/Vector3 linear; geometry_msgs/msg/Vector3 angular",
    "geometry_msgs/msg/TwistWithCovariance": "geometry_msgs/msg/Twist twist; float64[36] covariance",
    "geometry_msgs/msg/Transform": "geometry_msgs/msg/Vector3 translation; geometry_msgs/msg/Quaternion rotation",
    "geometry_msgs/msg/TransformStamped":
        "std_msgs/msg/Header header; string child_frame_id; geometry_msgs/msg/Transform transform",
    "sensor_msgs/msg/Imu":
        "std_msgs/msg/Header header; geometry_msgs/msg/Quaternion orientation; float64[9] orientation_covariance; "
        "geometry_msgs/msg/Vector3 angular_velocity; float64[9] angular_velocity_covariance; "
        "geometry_msgs/msg/Vector3 linear_acceleration; float64[9] linear_acceleration_covariance",
    "sensor_msgs/msg/Image":
        "std_msgs/msg/Header header; uint32 height; uint32 width; string encoding; uint8 is_bigendian; uint32 step; "
        "uint8[] data",
    "sensor_msgs/msg/CompressedImage": "std_msgs/msg/Header header; string format; uint8[] data",
    "sensor_msgs/msg/RegionOfInterest":
        "uint32 x_offset; uint32 y_offset; uint32 height; uint32 width; bool do_rectify",
    "sensor_msgs/msg/CameraInfo":
        "std_msgs/msg/Header header; uint32 height; uint32 width; string distortion_model; float64[] d; "
        "float64[9] k; float64[9] r; float64[12] p; uint32 binning_x; uint32 binning_y; "
        "sensor_msgs/msg/RegionOfInterest roi",
    "sensor_msgs/msg/PointField": "string name; uint32 offset; uint8 datatype; uint32 count",
    "sensor_msgs/msg/PointCloud2":
        "std_msgs/msg/Header header; uint32 height; uint32 width; sensor_msgs/msg/PointField[] fields; "
        "bool is_bigendian; uint32 point_step; uint32 row_step; uint8[] data; bool is_dense",
    "nav_msgs/msg/Odometry":
        "std_msgs/msg/Header header; string child_frame_id; geometry_msgs/msg/PoseWithCovariance pose; "
        "geometry_msgs/msg/TwistWithCovariance twist",
    "nav_msgs/msg/Path": "std_msgs/msg/Header header; geometry_msgs/msg/PoseStamped[] poses",
    "visualization_msgs/msg/UVCoordinate": "float32 u; float32 v",
    "visualization_msgs/msg/MeshFile": "string filename; uint8[] data",
    "visualization_msgs/msg/Marker":
        "std_msgs/msg/Header header; string ns; int32 id; int32 type; int32 action; geometry_msgs/msg/Pose pose; "
        "geometry_msgs/msg/Vector3 scale; std_msgs/msg/ColorRGBA color; time lifetime; bool frame_locked; "
        "geometry_msgs/msg/Point[] points; std_msgs/msg/ColorRGBA[] colors; string texture_resource; "
        "sensor_msgs/msg/CompressedImage texture; visualization_msgs/msg/UVCoordinate[] uv_coordinates; "
        "string text; string mesh_resource; visualization_msgs/msg/MeshFile mesh_file; "
        "bool mesh_use_embedded_materials",
    "visualization_msgs/msg/MarkerArray": "visualization_msgs/msg/Marker[] markers",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/msg/TransformStamped[] transforms",
    "diagnostic_msgs/msg/KeyValue": "string key; string value",
    "diagnostic_msgs/msg/DiagnosticStatus":
        "uint8 level; string name; string message; string hardware_id; diagnostic_msgs/msg/KeyValue[] values",
    "diagnostic_msgs/msg/DiagnosticArray":
        "std_msgs/msg/Header header; diagnostic_msgs/msg/DiagnosticStatus[] status",
}
NUMBERS = {"float64": "d", "float32": "f", "int32": "i", "uint32": "I", "uint8": "B", "bool": "?"}
HEAD = b"\0\1\0\0"


class Message:
    """Its fields are its attributes."""


class Time:
    def __init__(self, secs=0, nsecs=0):
        self.secs, self.nsecs = secs, nsecs

    def to_nsec(self):
        return self.secs * 10**9 + self.nsecs


def fields(kind):
    """(name, type, number) of each field: None for one value, -1 for a sequence, else the length of an array."""
    for field in DEFINITIONS[kind].split("; "):
        words, name = field.split(" ")
        base, _, length = words.partition("[")
        yield name, base, None if not length else int(length[:-1] or -1)


class Reader:
    def __init__(self, data):
        assert data[:2] == HEAD[:2], f"not little-endian CDR: {data[:4]}"  # the other two may count what is behind it
        self.data, self.place = memoryview(data)[4:], 0

    def take(self, count, letter):
        size = struct.calcsize(letter)
        self.place += -self.place % size if count else 0
        values = struct.unpack_from(f"<{count}{letter}", self.data, self.place)
        self.place += count * size
        return values

    def value(self, kind):
        if kind in NUMBERS:
            return self.take(1, NUMBERS[kind])[0]
        if kind == "time":
            return Time(self.take(1, "i")[0], self.take(1, "I")[0])
        if kind == "string":
            text = bytes(self.take(self.take(1, "I")[0], "B"))
            assert text[-1:] == b"\0", "a text without its end"
            return text[:-1].decode()
        message = Message()
        for name, base, length in fields(kind):
            setattr(message, name, self.value(base) if length is None else self.values(base, length))
        return message

    def values(self, kind, length):
        count = self.take(1, "I")[0] if length < 0 else length
        if kind == "uint8":
            return bytes(self.take(count, "B"))
        if kind in NUMBERS:
            return list(self.take(count, NUMBERS[kind]))
        return [self.value(kind) for _ in range(count)]


def decode(kind, data):
    reader = Reader(data)
    message = reader.value(kind)
    left = len(reader.data) - reader.place
    assert 0 <= left < 4, f"{kind}: {left} bytes behind it"
    return message


def encode(kind, values):
    """`values`: {field: value}, with dictionaries for messages; what is not there is zero or empty."""
    out = bytearray()

    def number(letter, *numbers):
        for value in numbers:
            out.extend(bytes(-len(out) % struct.calcsize(letter)))
            out.extend(struct.pack("<" + letter, value))

    def put(base, value):
        if base in NUMBERS:
            number(NUMBERS[base], value or 0)
        elif base == "time":
            number("i", (value or 0) // 10**9)
            number("I", (value or 0) % 10**9)
        elif base == "string":
            text = (value or "").encode() + b"\0"
            number("I", len(text))
            out.extend(text)
        else:
            for name, inner, length in fields(base):
                put_all(inner, length, (value or {}).get(name))

    def put_all(base, length, value):
        if length is None:
            put(base, value)
            return
        value = value if value is not None else [0] * max(length, 0)
        if length < 0:
            number("I", len(value))
        assert length in (-1, len(value)), f"{len(value)} values for {length}"
        if base == "uint8":
            out.extend(value)
        else:
            for one in value:
                put(base, one)

    put(kind, values)
    return HEAD + bytes(out)


def record(stamp, topic, kind, data):
    """As dds_peer.cpp has it."""
    out = struct.pack("<q", stamp)
    for part in (topic.encode(), kind.encode(), data):
        out += struct.pack("<I", len(part)) + part
    return out


class RecordFile:
    """Reads what dds_peer has written so far, and later what is new."""

    def __init__(self, file):
        self.file, self.place = file, 0

    def new(self):
        """(topic, type, bytes) of each record that is whole."""
        if not self.file.exists():
            return []
        with open(self.file, "rb") as stream:
            stream.seek(self.place)
            data = stream.read()
        found, place = [], 0
        while (parts := self.parts(data, place)) is not None:
            found.append((parts[0].decode(), parts[1].decode(), parts[2]))
            place += 8 + sum(4 + len(part) for part in parts)
        self.place += place
        return found

    @staticmethod
    def parts(data, place):
        place += 8
        parts = []
        for _ in range(3):
            if place + 4 > len(data):
                return None
            size = struct.unpack_from("<I", data, place)[0]
            if place + 4 + size > len(data):
                return None
            parts.append(data[place + 4:place + 4 + size])
            place += 4 + size
        return parts
