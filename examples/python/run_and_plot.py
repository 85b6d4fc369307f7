#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Runs a recording frame by frame, judges the poses, and draws path, sigmas and the map from above.

  python3 run_and_plot.py [SEQUENCE] [--out plot.png]

Without SEQUENCE a flight of 10 s is simulated. Without matplotlib it prints figures only.
"""

import argparse
import contextlib

import numpy as np

import facet

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    plt = None


def run(recording):
    """The odometry after the last frame, and the states of all frames."""
    vio = facet.Vio(recording.calibration)
    states = []
    for frame in recording:
        vio.add_imu(frame.imu_t_ns, frame.gyro, frame.accel)
        states.append(vio.add_stereo(frame.t_ns, frame.left, frame.right))
    return vio, states


def draw_path(axes, trajectory, mesh):
    """From above, over the map."""
    axes.triplot(*mesh.vertices[:, :2].T, mesh.faces, color="0.8", linewidth=0.2)
    axes.plot(*trajectory.p[:, :2].T, color="C3")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="path and map")


def draw_sigmas(axes, states):
    """How well the position is known along the run."""
    posed = [state for state in states if state.has_pose]
    seconds = 1e-9 * (np.array([state.t_ns for state in posed]) - states[0].t_ns)
    axes.plot(seconds, 1e3 * np.array([state.sigma_p for state in posed]), label=["x", "y", "z"])
    axes.set(xlabel="time [s]", ylabel="1-sigma of the position [mm]", title="uncertainty")
    axes.legend()


def plot(vio, states, trajectory, file):
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 5), layout="constrained")
    draw_path(left, trajectory, vio.map())
    draw_sigmas(right, states)
    figure.savefig(file)
    print("written:", file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", nargs="?")
    parser.add_argument("--out", default="plot.png")
    parser.add_argument("--duration", type=float, default=10, help="seconds of the flight that is simulated")
    a = parser.parse_args()
    with contextlib.ExitStack() as stack:
        if a.sequence:
            recording, truth = facet.Recording(a.sequence), a.sequence
        else:
            recording = stack.enter_context(facet.simulated(duration_s=a.duration))
            truth = recording.path
        vio, states = run(recording)
        trajectory = facet.Trajectory.of_states(states)
        print(f"{recording.name}: {len(states)} frames, {len(trajectory)} poses")
        for plane in vio.planes():
            print(f"plane {plane.id}: {plane.label}, {plane.area_m2:.1f} m2, n {np.round(plane.n, 3)}, d {plane.d:.3f} m")
        try:
            print(f"ATE {1e3 * facet.evaluate(trajectory, truth)['ate']['rmse_m']:.1f} mm")
        except facet.InputError as error:
            print("not judged:", error)
    if plt is None:
        print("no plot: matplotlib is not installed (Debian: apt install python3-matplotlib)")
    else:
        plot(vio, states, trajectory, a.out)


if __name__ == "__main__":
    main()
