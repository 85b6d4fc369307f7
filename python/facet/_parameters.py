# SPDX-License-Identifier: BSD-2-Clause
"""Parameters as keyword arguments: mesh={"map": {"enabled": False}} is mesh.map.enabled=false of the program."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Union

from . import _native

PathLike = Union[str, "os.PathLike[str]"]


def path_text(path: PathLike | None) -> str:
    """A path as the C++ side takes it: empty for none."""
    return "" if path is None else os.fspath(path)


def value_text(key: str, value: Any) -> str:
    """A value as it stands in YAML."""
    if isinstance(value, str):
        return value
    if hasattr(value, "item"):
        value = value.item()  # a scalar of NumPy
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"{key}: a parameter is a number, a text, True or False, not {type(value).__name__}")


def overrides(parameters: Mapping[str, Any], prefix: str = "") -> list[str]:
    """key.path=value for each parameter; dictionaries are groups, and a key may have dots: {"map.enabled": False}."""
    texts = []
    for key, value in parameters.items():
        path = f"{prefix}{key}"
        if isinstance(value, Mapping):
            texts += overrides(value, f"{path}.")
        else:
            texts.append(f"{path}={value_text(path, value)}")
    return texts


def config_text(*, config: PathLike | None = None, all: bool = False, **parameters: Any) -> str:
    """The parameters in force as YAML with their meanings and ranges: those that users turn, or all of them.

    What it returns, written to a file, is good for `config`.
    """
    return _native.config_text(path_text(config), overrides(parameters), all)
