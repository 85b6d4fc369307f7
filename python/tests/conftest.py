# SPDX-License-Identifier: BSD-2-Clause
"""A short simulated flight that all tests share, and what the program makes of it."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import facet

DURATION_S = 2.5
SIMULATE = ["--scene", "room", "--trajectory", "gentle", "--duration", str(DURATION_S)]


@pytest.fixture(scope="session")
def program():
    path = os.environ.get("FACET_PROGRAM")
    if not path:
        pytest.skip("FACET_PROGRAM does not name the program facet")

    def call(*arguments):
        done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call


@pytest.fixture(scope="session")
def sequence(tmp_path_factory) -> Path:
    from facet import _native

    if not _native.has_simulator:
        pytest.skip("this build has no simulator (Embree 3)")
    return facet.simulate(tmp_path_factory.mktemp("data") / "flight", duration_s=DURATION_S)


@pytest.fixture(scope="session")
def result(sequence, tmp_path_factory) -> facet.Result:
    return facet.run(sequence, tmp_path_factory.mktemp("run") / "result")


@pytest.fixture(scope="session")
def frames(sequence) -> list:
    return list(facet.Recording(sequence))


@pytest.fixture()
def calibration() -> facet.Calibration:
    """Of cameras of 320 x 240 pixels, 11 cm apart, that look along the body's x axis."""
    def camera(y_m):
        T_BC = np.array([[0, 0, 1, 0], [-1, 0, 0, y_m], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=float)
        return facet.Camera(320, 240, 200, 200, 160, 120, T_BC)

    return facet.Calibration(camera(0.055), camera(-0.055))


def fly(vio: facet.Vio, frames, images=lambda frame: (frame.left, frame.right), **options) -> list:
    """The states of all frames."""
    states = []
    for frame in frames:
        vio.add_imu(frame.imu_t_ns, frame.gyro, frame.accel)
        states.append(vio.add_stereo(frame.t_ns, *images(frame), **options))
    return states


def poses(states) -> np.ndarray:
    return np.array([[*state.p, *state.q] for state in states if state.has_pose])
