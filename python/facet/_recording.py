# SPDX-License-Identifier: BSD-2-Clause
"""Recordings of all kinds as arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping

from . import _native
from ._parameters import PathLike, path_text


def topic_texts(topics: Mapping[str, str] | None) -> list[str]:
    return [f"{role}={name}" for role, name in (topics or {}).items()]


def require_range(**seconds: float) -> None:
    for name, value in seconds.items():
        if not value >= 0:
            raise ValueError(f"{name}: seconds, at least 0, are expected, not {value}")


class Recording(_native.Recording):
    """A recording, or a part of it, as `facet run` reads it: folders (EuRoC, KITTI, left/ right/ imu.csv), bags.

        recording = facet.Recording("MH_01_easy", duration_s=10)
        vio = facet.Vio(recording.calibration)
        for frame in recording:
            vio.add_imu(frame.imu_t_ns, frame.gyro, frame.accel)
            state = vio.add_stereo(frame.t_ns, frame.left, frame.right)

    This gives the poses of `facet run`, byte for byte, as long as left and right images have the same stamps; where
    they differ (frame.t_right_ns), `facet run` first turns the right image by what the gyroscope says.

    `topics`: names of a bag's topics by their role: left, right, imu (or gyro, accel). `imu_history_s`: how much of the
    IMU from before the first frame comes with it. Each iteration begins at the beginning. Raises facet.InputError for
    what cannot be read, during an iteration where the recording is damaged.
    """

    def __init__(
        self,
        path: PathLike,
        *,
        calibration: PathLike | None = None,
        imu_calibration: PathLike | None = None,
        topics: Mapping[str, str] | None = None,
        start_s: float = 0,
        duration_s: float = math.inf,
        imu_history_s: float = 0,
        check_calibration: bool = True,
    ) -> None:
        require_range(start_s=start_s, duration_s=duration_s, imu_history_s=imu_history_s)
        super().__init__(path_text(path), path_text(calibration), path_text(imu_calibration), topic_texts(topics),
                         start_s, duration_s, imu_history_s, check_calibration)
