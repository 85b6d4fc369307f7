"""Simulated flights for the scripts that try many starts and many laps: made once, kept in a folder.

Most are closed: position, attitude and all their derivatives are periodic, so that the end of a lap joins its beginning
and the same images and the same motion can be played again and again (build/bench/laps). The others follow recorded
motions of the data folder, with the recorded IMU, or walk through the corridor.
"""

import math
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
LAP_S = 40
RATE_HZ = 200
FIRST_STAMP_NS = 1_500_000_000_000_000_000
MARGIN_S = 0.8  # of poses before and after the lap, for the simulator's spline
SIMULATOR_MARGIN_S = 0.3  # what it keeps for itself at the beginning
FRAME_HZ = 20


@dataclass
class Flight:
    """One sequence: what kind of motion it has, and how it is made."""

    name: str
    kind: str  # rest, moving, rotating, fast, hand-held, walking, real
    scene: list  # arguments of `facet simulate`
    poses: object = None  # function of the time: position, heading, pitch, roll, all periodic
    recording: tuple = field(default=())  # truth and IMU file in the data folder, or none
    duration_s: float = LAP_S

    def is_closed(self):
        return self.poses is not None


def wave(t, turns, phase=0.0):
    """A sine with that many turns in a lap."""
    return math.sin(2 * math.pi * turns * t / LAP_S + phase)


def rest_then_round(t):
    """Exactly at rest for 9 s, then around the room, and back to rest."""
    share = min(max((t % LAP_S - 9) / (LAP_S - 12), 0), 1)
    angle = 2 * math.pi * (share - math.sin(2 * math.pi * share) / (2 * math.pi))
    at = (1.4 * math.cos(angle), 1.4 * math.sin(angle), 1.3 + 0.25 * math.sin(3 * angle))
    return at, angle + math.pi / 2 + 0.5 * math.sin(2 * angle), 0.1 * math.sin(3 * angle), 0.06 * math.sin(5 * angle)


def gentle_round(t):
    at = (1.6 * wave(t, 1, math.pi / 2), 1.6 * wave(t, 1), 1.4 + 0.2 * wave(t, 3) + 0.03 * wave(t, 31))
    heading = 2 * math.pi * t / LAP_S + math.pi / 2 + 0.4 * wave(t, 5)
    return at, heading, 0.12 * wave(t, 7) + 0.02 * wave(t, 43), 0.08 * wave(t, 6) + 0.02 * wave(t, 53)


def fast_round(t):
    angle = 2 * math.pi * 6 * t / LAP_S
    at = (1.9 * math.cos(angle), 1.7 * math.sin(angle), 1.5 + 0.35 * wave(t, 13))
    return at, angle + math.pi / 2 + 0.5 * wave(t, 17), 0.2 * wave(t, 19) + 0.05 * wave(t, 71), 0.25 * wave(t, 23)


def mostly_turning(t):
    """On the spot: sweeps of the heading to both sides, nodding, with stops between them."""
    share = t % LAP_S / LAP_S
    sweep = math.sin(2 * math.pi * 4 * share) ** 3
    at = (0.03 * wave(t, 5), 0.03 * wave(t, 4), 1.4 + 0.02 * wave(t, 7))
    return at, 2 * math.pi * share + 1.6 * sweep, 0.3 * wave(t, 9), 0.15 * wave(t, 11)


def hovering(t):
    at = (0.07 * wave(t, 4), 0.06 * wave(t, 7), 1.3 + 0.05 * wave(t, 5))
    return at, 0.15 * wave(t, 3) + 0.02 * wave(t, 37), 0.03 * wave(t, 41), 0.03 * wave(t, 47)


def waved_by_hand(t):
    at = (0.35 * wave(t, 9) + 0.1 * wave(t, 2), 0.3 * wave(t, 14), 1.3 + 0.25 * wave(t, 17))
    return at, 0.6 * wave(t, 5) + 0.1 * wave(t, 33), 0.3 * wave(t, 13) - 0.2, 0.2 * wave(t, 21)


FLIGHTS = [
    Flight("room-rest", "rest", ["--scene", "room", "--seed", "31", "--set", "imu.vibration=0.1"], rest_then_round),
    Flight("room-gentle", "moving", ["--scene", "room", "--seed", "32"], gentle_round),
    Flight("room-turning", "rotating", ["--scene", "room", "--seed", "33"], mostly_turning),
    Flight("room-fast", "fast", ["--scene", "room", "--seed", "34"], fast_round),
    Flight("room-hand", "hand-held", ["--scene", "room", "--seed", "35", "--set", "near_things_m=0.5",
                                      "--set", "imu.vibration=0.2"], waved_by_hand),
    Flight("clutter-gentle", "moving", ["--scene", "clutter", "--seed", "36"], gentle_round),
    Flight("clutter-hover", "rest", ["--scene", "clutter", "--seed", "37"], hovering),
    Flight("corridor-walk", "walking", ["--scene", "corridor", "--seed", "38", "--trajectory", "walk"]),
    Flight("room-V1_02", "real", ["--scene", "room", "--seed", "39"],
           recording=("euroc_flights/V1_02_medium/groundtruth.csv", "euroc_flights/V1_02_medium/imu.csv")),
    Flight("room-MH_01", "hand-held", ["--scene", "room", "--seed", "40", "--set", "near_things_m=0.5"],
           recording=("euroc_mh01_handheld/mav0/state_groundtruth_estimate0/data.csv",
                      "euroc_mh01_handheld/mav0/imu0/data.csv"), duration_s=0),
    Flight("room-MH_05", "real", ["--scene", "room", "--seed", "41"],
           recording=("euroc_flights/MH_05_difficult/groundtruth.csv", "euroc_flights/MH_05_difficult/imu.csv")),
    Flight("room-aggressive", "fast", ["--scene", "room", "--seed", "42", "--trajectory", "aggressive"]),
    Flight("corridor-10Hz", "walking", ["--scene", "corridor", "--seed", "43", "--trajectory", "walk",
                                        "--draw-calibration", "43", "--set", "image.rate_hz=10"]),
]


def attitude(heading, pitch, roll):
    """Body axes as EuRoC's: x up, z forward; quaternion w, x, y, z."""
    c, s = math.cos, math.sin
    turn = np.array([[c(heading), -s(heading), 0], [s(heading), c(heading), 0], [0, 0, 1]])
    nod = np.array([[c(pitch), 0, s(pitch)], [0, 1, 0], [-s(pitch), 0, c(pitch)]])
    bank = np.array([[1, 0, 0], [0, c(roll), -s(roll)], [0, s(roll), c(roll)]])
    body = np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0]])
    return quaternion(turn @ nod @ bank @ body)


def quaternion(R):
    """By the largest of the four, so that no root is near zero."""
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
                  [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]]) / 3
    vectors = np.linalg.eigh(K)[1]
    return vectors[[3, 0, 1, 2], 3]


def write_poses(poses, file):
    """One lap and a little on both sides, as ground truth in EuRoC's format."""
    count = round((LAP_S + 2 * MARGIN_S) * RATE_HZ) + 1
    previous = None
    with open(file, "w", encoding="utf-8") as stream:
        stream.write("#timestamp,px,py,pz,qw,qx,qy,qz,vx,vy,vz,bwx,bwy,bwz,bax,bay,baz\n")
        for i in range(count):
            t = i / RATE_HZ - MARGIN_S
            p, heading, pitch, roll = poses(t)
            q = attitude(heading, pitch, roll)
            if previous is not None and previous @ q < 0:
                q = -q
            previous = q
            stamp = FIRST_STAMP_NS + round(1e9 * t)
            stream.write(f"{stamp}," + ",".join(f"{x:.12g}" for x in (*p, *q, *[0.0] * 9)) + "\n")


def data_folder():
    return Path(os.environ.get("FACET_DATA_DIR") or ROOT.parent / "shared" / "data")


def make_takes(flight, cache, program, count):
    """`count` folders of one flight that differ in their noise only, simulated if they are not there."""
    folders = [Path(cache) / f"{flight.name}-{i + 1}" for i in range(count)]
    if not all((folder / "simulation.txt").exists() for folder in folders):
        for folder in folders:
            shutil.rmtree(folder, ignore_errors=True)
        make(replace(flight, scene=[*flight.scene, "--noise-seeds", str(count)]), cache, program)
    return folders


def make(flight, cache, program):
    """The folder of a flight, simulated if it is not there; None where its recording is missing."""
    folder = Path(cache) / flight.name
    if (folder / "simulation.txt").exists():
        return folder
    command = [str(program), "simulate", "--quiet", "--out", str(folder), "--set", "image.rays_per_pixel=2",
               "--set", "image.max_rays_per_pixel=6", "--set", f"image.rate_hz={FRAME_HZ}", *flight.scene]
    with tempfile.TemporaryDirectory() as scratch:
        if flight.is_closed():
            # One exposure for all images, because a drifting one would jump where the lap begins again.
            path = Path(scratch) / "poses.csv"
            write_poses(flight.poses, path)
            command += ["--trajectory", str(path), "--start", str(MARGIN_S - SIMULATOR_MARGIN_S),
                        "--duration", str(LAP_S - 1 / FRAME_HZ), "--set", "image.auto_exposure=false"]
        elif flight.recording:
            truth, imu = (data_folder() / name for name in flight.recording)
            if not truth.exists():
                return None
            command += ["--trajectory", str(truth), "--imu", str(imu)]
        if not flight.is_closed() and flight.duration_s:
            command += ["--duration", str(flight.duration_s)]
        shutil.rmtree(folder, ignore_errors=True)
        folder.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(command, check=True)
    return folder


def make_all(cache, program, flights=tuple(FLIGHTS)):
    """[(flight, folder)] of all that can be made."""
    made = []
    for flight in flights:
        folder = make(flight, cache, program)
        if folder is None:
            print(f"{flight.name}: left out, its recording is not in {data_folder()}")
        else:
            made.append((flight, folder))
    return made
