# SPDX-License-Identifier: BSD-2-Clause
"""Runs the tests of the Python package; exit code 77, and the reason, where they cannot be run."""

import importlib.util
import sys
from pathlib import Path

SKIPPED = 77


def main() -> int:
    missing = [name for name in ("numpy", "pytest") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"skipped: {sys.executable} has no {', '.join(missing)} (Debian: python3-numpy, python3-pytest)")
        return SKIPPED
    import pytest

    return pytest.main(["-q", "-p", "no:cacheprovider", str(Path(__file__).parent), *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
