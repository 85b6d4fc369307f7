#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""What Python costs per stereo frame: the time of its calls less that which they spend in Facet.

  PYTHONPATH=build/python /usr/bin/python3 bench/python_overhead.py [SEQUENCE] [--limit MICROSECONDS]

For each frame all of its IMU samples are added by one call, then the images by another, and position, quaternion and
status are read. Allocating and freeing the images belongs to whoever makes them and is not counted. Without SEQUENCE a
flight of 5 s is simulated. Also printed: the mesh as arrays, per keyframe. With --limit the exit code is 1 where the
median is above it.
"""

import argparse
import collections
import contextlib
import statistics
import sys
import time

import facet


def measure(recording):
    """Microseconds per frame beside Facet's own, those in Facet, and those that the mesh's arrays take."""
    vio = facet.Vio(recording.calibration)
    beside, inside, arrays = [], [], []
    newest = collections.deque(maxlen=5)  # images are freed here and not in the call that lets go of them
    for frame in recording:
        newest.append(frame)
        t_ns, left, right = frame.t_ns, frame.left, frame.right
        imu = frame.imu_t_ns, frame.gyro, frame.accel
        inside_before = vio.seconds_inside
        start = time.perf_counter()
        vio.add_imu(*imu)
        state = vio.add_stereo(t_ns, left, right)
        if state.has_pose and state.status != "lost":
            state.p, state.q
        wall = time.perf_counter() - start
        in_facet = vio.seconds_inside - inside_before
        beside.append(1e6 * (wall - in_facet))
        inside.append(1e6 * in_facet)
        if state.is_keyframe:
            mesh = vio.mesh()
            start = time.perf_counter()
            mesh.vertices, mesh.faces, mesh.plane_ids
            arrays.append(1e6 * (time.perf_counter() - start))
    return beside, inside, arrays


def describe(name, values):
    values = sorted(values)
    print(f"{name}: median {statistics.median(values):.1f} us, mean {statistics.fmean(values):.1f}, "
          f"p90 {values[int(0.9 * len(values))]:.1f} ({len(values)} frames)")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", nargs="?")
    parser.add_argument("--limit", type=float)
    a = parser.parse_args()
    with contextlib.ExitStack() as stack:
        recording = facet.Recording(a.sequence) if a.sequence else stack.enter_context(facet.simulated(duration_s=5))
        beside, inside, arrays = measure(recording)
    describe("Python beside Facet", beside)
    describe("in Facet", inside)
    describe("mesh as arrays", arrays)
    return 1 if a.limit is not None and statistics.median(beside) > a.limit else 0


if __name__ == "__main__":
    sys.exit(main())
