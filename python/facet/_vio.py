# SPDX-License-Identifier: BSD-2-Clause
"""The odometry for live images."""

from __future__ import annotations

import warnings
from typing import Any

from . import _native
from ._parameters import PathLike, overrides, path_text


class Vio(_native.Vio):
    """Stereo pairs and IMU samples in, poses, mesh and planes out; deterministic.

        vio = facet.Vio(calibration, config="paper.yaml", mesh={"map": {"enabled": False}})

    `config` is a YAML file with any subset of the parameters, the other keyword arguments are parameters by their
    groups (facet.config_text() lists them) and win over the file. Raises facet.Error where one of them, or the
    calibration, is wrong. Calls from several threads are done one after the other.
    """

    def __init__(self, calibration: _native.Calibration, *, config: PathLike | None = None, **parameters: Any) -> None:
        super().__init__(calibration, path_text(config), overrides(parameters))
        for notice in self.notices:
            warnings.warn(notice, stacklevel=2)
