# SPDX-License-Identifier: BSD-2-Clause
"""Recordings with exact truth."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from . import _native
from ._parameters import PathLike, overrides, path_text
from ._recording import Recording


def simulate(
    out: PathLike,
    *,
    scene: PathLike = "room",
    trajectory: PathLike = "gentle",
    imu_file: PathLike | None = None,
    calibration_file: PathLike | None = None,
    textures: PathLike | None = None,
    seed: int = 1,
    start_s: float = 0,
    duration_s: float = 0,
    threads: int | None = None,
    clean_images: bool = False,
    clean_imu: bool = False,
    draw_calibration: int | None = None,
    lens_misfit: int | None = None,
    **parameters: Any,
) -> Path:
    """Writes the sequence `out` with its truth: `facet simulate`, with the same images, samples and truth.

        facet.simulate("fast", trajectory="fast", duration_s=10, imu={"add_bias": False})

    `scene`: room, corridor, clutter, office, hall, facade, or a scene file; `trajectory`: gentle, fast, aggressive,
    hover, hand-held, walk, or ground truth (csv), for which `imu_file` may be the IMU that recorded it. `duration_s` 0:
    20 s, or the whole recorded trajectory. `calibration_file`: as for facet.run; without it EuRoC's vehicle flies.
    `draw_calibration`: a seed; the sequence then has the calibration that a careful one would have written. The keyword
    arguments that are not named above are options by their groups (`facet simulate --list` prints them). Returns `out`.
    """
    if not _native.has_simulator:
        raise _native.Error("this build has no simulator; install Embree 3 (Debian: libembree-dev) and build again")
    if not (duration_s >= 0 and start_s >= 0):
        raise ValueError("start_s, duration_s: seconds, at least 0, are expected")
    threads = threads or os.cpu_count() or 1
    texts = overrides(parameters)
    command = " ".join([f"facet.simulate of Python: scene={path_text(scene)} trajectory={path_text(trajectory)}",
                        f"seed={seed} start_s={start_s:g} duration_s={duration_s:g}", *texts])
    _native.simulate(path_text(out), path_text(scene), path_text(trajectory), path_text(imu_file), path_text(calibration_file),
                     path_text(textures), seed, start_s, duration_s, threads, clean_images, clean_imu,
                     draw_calibration, lens_misfit, texts, command)
    return Path(out)


@contextmanager
def simulated(**options: Any) -> Iterator[Recording]:
    """A simulated recording as arrays, without a folder that stays: options as for facet.simulate.

        with facet.simulated(duration_s=5) as recording:
            for frame in recording: ...

    The truth is at `recording.path`, for facet.evaluate and facet.read_truth, until the block ends.
    """
    with tempfile.TemporaryDirectory(prefix="facet-") as folder:
        path = simulate(Path(folder) / "sequence", **options)
        recording = Recording(path)
        recording.path = path
        yield recording
