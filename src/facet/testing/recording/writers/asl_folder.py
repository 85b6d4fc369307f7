"""What the writers of test recordings read: a sequence in the ASL layout, merged by time."""

import csv
from pathlib import Path


def rows(file):
    with open(file, newline="") as stream:
        for row in csv.reader(stream):
            if row and not row[0].startswith("#"):
                yield row


def events(sequence, duration_s):
    """(stamp in ns, "cam0", "cam1" or "imu0", file or six numbers), by time; the IMU ends half a second later."""
    mav0 = Path(sequence) / "mav0"
    found = []
    for camera in ("cam0", "cam1"):
        for row in rows(mav0 / camera / "data.csv"):
            found.append((int(row[0]), camera, mav0 / camera / "data" / row[1].strip()))
    first = min(event[0] for event in found)
    last = first + int(duration_s * 1e9)
    found = [event for event in found if event[0] <= last]
    for row in rows(mav0 / "imu0" / "data.csv"):
        if int(row[0]) <= last + 500_000_000:
            found.append((int(row[0]), "imu0", [float(value) for value in row[1:7]]))
    return sorted(found, key=lambda event: (event[0], event[1]))


def read_pgm(content):
    """(width, height, pixels) of a binary PGM file with 8 bits; None for any other file."""
    if not content.startswith(b"P5"):
        return None
    parts = content.split(None, 4)
    width, height = int(parts[1]), int(parts[2])
    return width, height, content[len(content) - width * height:]
