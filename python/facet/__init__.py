# SPDX-License-Identifier: BSD-2-Clause
"""Stereo visual-inertial odometry that builds a mesh and finds planes.

    import facet

    result = facet.run("MH_01_easy", "result")              # as `facet run`, writes the same files
    print(facet.evaluate(result, "MH_01_easy")["ate"])      # as `facet evaluate`

    vio = facet.Vio(facet.read_calibration("camchain.yaml", "imu.yaml"))
    vio.add_imu(t_ns, gyro, accel)                          # in order of time
    state = vio.add_stereo(t_ns, left, right)               # uint8 images, not copied
    mesh = vio.mesh()                                       # mesh.vertices, mesh.faces: NumPy arrays

Frames: W is the world (z up, origin at the first pose), B the body, which is the IMU. T_WB maps points from B to W.
Quaternions are w x y z. SI units; stamps are integers, nanoseconds of the recording's own clock.
"""

from ._evaluation import Trajectory, evaluate, read_trajectory, read_truth
from ._native import (
    Calibration,
    Camera,
    ConfigError,
    Error,
    Frame,
    InputError,
    Mesh,
    OutputError,
    Plane,
    RunEnded,
    State,
    __version__,
    read_calibration,
    read_mesh,
)
from ._parameters import config_text
from ._recording import Recording
from ._run import Result, run
from ._simulation import simulate, simulated
from ._vio import Vio

__all__ = [
    "Calibration",
    "Camera",
    "ConfigError",
    "Error",
    "Frame",
    "InputError",
    "Mesh",
    "OutputError",
    "Plane",
    "Recording",
    "Result",
    "RunEnded",
    "State",
    "Trajectory",
    "Vio",
    "__version__",
    "config_text",
    "evaluate",
    "read_calibration",
    "read_mesh",
    "read_trajectory",
    "read_truth",
    "run",
    "simulate",
    "simulated",
]
