# SPDX-License-Identifier: BSD-2-Clause
"""Recordings to result folders, and what is in these."""

from __future__ import annotations

import csv
import json
import math
import os
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _native
from ._evaluation import Trajectory, evaluate, read_trajectory
from ._parameters import PathLike, overrides, path_text
from ._recording import require_range, topic_texts

INTERRUPTED = 130  # exit code


def _column(texts: list[str]) -> np.ndarray:
    """Integers, numbers or texts, whichever all of them are."""
    for kind in (np.int64, np.float64):
        try:
            return np.array(texts).astype(kind)
        except (ValueError, OverflowError):
            continue
    return np.array(texts, dtype=str)


def _read_table(file: Path) -> dict[str, np.ndarray]:
    try:
        with open(file, newline="", encoding="utf-8") as lines:
            header, *rows = csv.reader(lines)
    except (FileNotFoundError, ValueError) as error:
        raise _native.InputError(f"{file}: no table; a result folder of facet run has one there") from error
    if any(len(row) != len(header) for row in rows):
        raise _native.InputError(f"{file}: its lines do not have as many columns as its header, {len(header)}")
    columns = zip(*rows) if rows else [()] * len(header)
    return {name.lstrip("#"): _column(list(column)) for name, column in zip(header, columns)}


def _is_without_poses(file: Path) -> bool:
    """Whether it is there and holds comments only: no frame got a pose."""
    if not file.is_file():
        return False
    with open(file, encoding="utf-8", errors="replace") as lines:
        return all(line.isspace() or line.startswith("#") for line in lines)


class Result(os.PathLike):
    """A result folder of facet.run or `facet run`; files are read when they are asked for."""

    def __init__(self, path: PathLike) -> None:
        self.path = Path(path)
        if not (self.path / "summary.json").is_file():
            raise _native.InputError(f"{self.path}: no summary.json; a result folder of facet run is expected")

    def __fspath__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        return f"<facet.Result {self.path}>"

    @property
    def summary(self) -> dict[str, Any]:
        """Figures of the run: summary.json."""
        return json.loads((self.path / "summary.json").read_text(encoding="utf-8"))

    @property
    def trajectory(self) -> Trajectory:
        """The causal poses: trajectory.tum."""
        return self._poses("trajectory.tum")

    @property
    def keyframes(self) -> Trajectory:
        """The smoothed poses of the keyframes: keyframes.tum."""
        return self._poses("keyframes.tum")

    @property
    def states(self) -> dict[str, np.ndarray]:
        """The columns of states.csv by their names, a row for each frame."""
        return _read_table(self.path / "states.csv")

    @property
    def timing(self) -> dict[str, np.ndarray]:
        """The columns of timing.csv by their names, a row for each frame."""
        return _read_table(self.path / "timing.csv")

    @property
    def planes(self) -> dict[str, np.ndarray]:
        """The columns of planes.csv by their names, a row for each plane."""
        return _read_table(self.path / "planes.csv")

    def mesh(self) -> _native.Mesh:
        """The mesh of the last seconds: mesh.ply."""
        return _native.read_mesh(str(self.path / "mesh.ply"))

    def map(self) -> _native.Mesh:
        """The mesh of the whole run: map.ply."""
        return _native.read_mesh(str(self.path / "map.ply"))

    def evaluate(self, truth: PathLike, **options: Any) -> dict[str, Any]:
        """facet.evaluate of this result."""
        return evaluate(self, truth, **options)

    def _poses(self, name: str) -> Trajectory:
        file = self.path / name
        return read_trajectory(file) if not _is_without_poses(file) else Trajectory.of_states([])


def run(
    recording: PathLike,
    out: PathLike,
    *,
    config: PathLike | None = None,
    calibration: PathLike | None = None,
    imu_calibration: PathLike | None = None,
    topics: Mapping[str, str] | None = None,
    start_s: float = 0,
    duration_s: float = math.inf,
    imu_history_s: float = 0,
    threads: int = 1,
    mesh_every: int = 0,
    mesh_format: str = "ply",
    progress: Callable[[int, int], None] | None = None,
    **parameters: Any,
) -> Result:
    """Estimates the trajectory of a recording and writes the result folder `out`: `facet run`, with the same bytes.

        facet.run("MH_01_easy", "result", pipeline="S", mesh={"map": {"voxel_m": 0.05}})

    `config` is a YAML file with any subset of the parameters, the other keyword arguments are parameters by their
    groups (facet.config_text() lists them) and win over the file. `progress(done, total)` is called after each frame;
    an exception that it raises ends the run. What the program prints as notes and warnings comes as Python warnings.

    Raises facet.InputError, facet.ConfigError and facet.OutputError where nothing was written, and facet.RunEnded or
    KeyboardInterrupt (Ctrl-C) after what there was until then was written.
    """
    require_range(start_s=start_s, duration_s=duration_s, imu_history_s=imu_history_s)
    if not 1 <= threads <= 64:
        raise ValueError(f"threads: 1 to 64 are expected, not {threads}")
    if mesh_every < 0:
        raise ValueError(f"mesh_every: at least 0 is expected, not {mesh_every}")
    if mesh_format not in ("ply", "glb"):
        raise ValueError(f"mesh_format: ply or glb is expected, not {mesh_format}")
    messages = []
    try:
        _native.run(path_text(recording), path_text(out), path_text(config), overrides(parameters),
                    path_text(calibration), path_text(imu_calibration), topic_texts(topics), start_s,
                    duration_s, imu_history_s, threads, mesh_every, mesh_format, progress, messages)
    except _native.RunEnded as ended:
        if ended.exit_code == INTERRUPTED:
            raise KeyboardInterrupt(str(ended)) from ended
        ended.result = Result(out)
        raise
    finally:  # they are wanted most where a run ends early
        for message in messages:
            warnings.warn(message, stacklevel=2)
    return Result(out)
