#!/usr/bin/python3
"""write_db3.py SEQUENCE OUT_FOLDER DURATION [PARTS]: a ROS 2 bag (sqlite3) with metadata.yaml, in PARTS files.

By Python's sqlite3 and struct alone. PGM images become sensor_msgs/msg/Image, all others CompressedImage.
"""

import sqlite3
import sys
from pathlib import Path

import cdr
from asl_folder import events, read_pgm

SCHEMA = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
  data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES(3, 'humble');
"""


def message(stamp, sensor, what):
    """Name, type and content."""
    if sensor == "imu0":
        return "/imu0", "sensor_msgs/msg/Imu", cdr.imu(stamp, sensor, what)
    content = what.read_bytes()
    pixels = read_pgm(content)
    topic = f"/{sensor}/image_raw"
    if pixels is None:
        return topic + "/compressed", "sensor_msgs/msg/CompressedImage", cdr.compressed_image(
            stamp, sensor, what.suffix[1:], content)
    return topic, "sensor_msgs/msg/Image", cdr.image(stamp, sensor, *pixels)


def write_part(file, part):
    database = sqlite3.connect(file)
    database.executescript(SCHEMA)
    ids = {}
    for stamp, sensor, what in part:
        name, kind, data = message(stamp, sensor, what)
        if name not in ids:
            ids[name] = len(ids) + 1
            database.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')", (ids[name], name, kind))
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", (ids[name], stamp, data))
    database.commit()
    database.close()


def main():
    sequence, out, duration_s = sys.argv[1], Path(sys.argv[2]), float(sys.argv[3])
    num_parts = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    out.mkdir(parents=True)
    everything = events(sequence, duration_s)
    names = []
    for i in range(num_parts):
        part = everything[len(everything) * i // num_parts:len(everything) * (i + 1) // num_parts]
        names.append(f"{out.name}_{i}.db3")
        write_part(out / names[-1], part)
    (out / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  compression_format: \"\"\n"
        "  compression_mode: \"\"\n  relative_file_paths:\n" + "".join(f"    - {name}\n" for name in names))


if __name__ == "__main__":
    main()
