# SPDX-License-Identifier: BSD-2-Clause
"""Trajectories and how good they are."""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._parameters import PathLike, path_text

PARTS = ("mesh", "planes", "consistency")


@dataclass
class Trajectory:
    """Poses by rising stamps."""

    t_ns: npt.NDArray[np.int64]
    """N stamps."""
    p: npt.NDArray[np.float64]
    """N x 3, positions of the body in the world [m]."""
    q: npt.NDArray[np.float64]
    """N x 4, rotations from body to world: quaternions w x y z."""

    def __len__(self) -> int:
        return len(self.t_ns)

    def write(self, file: PathLike) -> None:
        """As a TUM file, with the stamps exact to the nanosecond: the format of trajectory.tum."""
        _native.write_tum(path_text(file), self.t_ns, self.p, self.q)

    @staticmethod
    def of_states(states: Sequence[_native.State]) -> Trajectory:
        """The poses of those states that have one."""
        posed = [state for state in states if state.has_pose]
        return Trajectory(
            np.array([state.t_ns for state in posed], dtype=np.int64),
            np.array([state.p for state in posed], dtype=np.float64).reshape(-1, 3),
            np.array([state.q for state in posed], dtype=np.float64).reshape(-1, 4),
        )


def read_trajectory(file: PathLike) -> Trajectory:
    """A TUM file or a csv file in EuRoC's format."""
    return Trajectory(*_native.read_trajectory(path_text(file)))


def read_truth(sequence: PathLike) -> Trajectory:
    """The true poses of a sequence folder, or of a trajectory file."""
    return Trajectory(*_native.read_truth(path_text(sequence)))


def _fields(trajectory: Trajectory) -> tuple[Any, Any, Any]:
    return trajectory.t_ns, trajectory.p, trajectory.q


def _evaluate_trajectory(estimate: Trajectory, truth: Any, options: tuple[str, list[float]]) -> tuple[str, list[str]]:
    true_poses = truth if isinstance(truth, Trajectory) else read_truth(truth)
    return _native.evaluate_poses(_fields(estimate), _fields(true_poses), *options)


def evaluate(
    result: Union[PathLike, Trajectory],
    truth: Union[PathLike, Trajectory],
    *,
    alignment: str = "se3",
    rpe_lengths_m: Sequence[float] = (),
    align_time: bool = False,
    parts: Sequence[str] | None = None,
    write: bool = False,
) -> dict[str, Any]:
    """The numbers of `facet evaluate`, as in evaluation.json: "ate" {"rmse_m", ...}, "rpe" [{"length_m", ...}], ...

    `result` is a folder of facet.run, a trajectory file, or a Trajectory; `truth` a sequence folder, a trajectory file,
    or a Trajectory. Trajectories in memory are judged alone, without meshes, planes and coverage. `alignment`: se3, yaw
    or sim3. `parts`: what is judged beside the trajectory and then must be there; without it mesh, planes and
    consistency, where there is truth for them. `write`: also write evaluation.json. Raises facet.InputError for what
    cannot be judged.
    """
    unknown = set(parts or ()) - {*PARTS, "trajectory"}
    if unknown:
        raise ValueError(f"parts: {', '.join(sorted(unknown))} is unknown; known: trajectory, {', '.join(PARTS)}")
    lengths = [float(length) for length in rpe_lengths_m]
    if not all(length > 0 for length in lengths):
        raise ValueError("rpe_lengths_m: lengths of path [m] above 0 are expected")
    if isinstance(result, Trajectory):
        if align_time or write or parts:
            raise ValueError("align_time, parts and write need a result folder or a file, not a Trajectory")
        text, notes = _evaluate_trajectory(result, truth, (alignment, lengths))
    elif isinstance(truth, Trajectory):
        raise ValueError("truth: with a result folder or file it is a path; read_trajectory(file) reads the result")
    else:
        text, notes = _native.evaluate_result(path_text(result), path_text(truth), alignment, lengths, align_time,
                                              list(PARTS if parts is None else parts), parts is not None, write)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return json.loads(text)
