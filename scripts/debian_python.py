"""Imported first by the scripts that need numpy: another Python may come first on the PATH (pyenv, conda) and lack it.
Then the script is started again with Debian's, for which `make setup` installs what is needed."""

import importlib.util
import os
import sys

DEBIAN_PYTHON = "/usr/bin/python3"

if importlib.util.find_spec("numpy") is None:
    if os.path.realpath(sys.executable) == os.path.realpath(DEBIAN_PYTHON) or not os.path.exists(DEBIAN_PYTHON):
        sys.exit("this script needs numpy and matplotlib: make setup, or python3 -m pip install numpy matplotlib")
    os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
