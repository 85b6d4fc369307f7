# SPDX-License-Identifier: BSD-2-Clause
# Looks for what the Python package needs, and turns FACET_BUILD_PYTHON off where something is missing, unless it is
# REQUIRED. Debian's pybind11 and NumPy are those of Debian's interpreter, which need not be the first one in PATH.

set(PYBIND11_FINDPYTHON ON)
if(NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.10 QUIET CONFIG)
if(NOT Python_Development.Module_FOUND OR NOT pybind11_FOUND)
  if(FACET_BUILD_PYTHON STREQUAL "REQUIRED")
    message(FATAL_ERROR "Python's headers or pybind11 not found; install them (Debian: apt install pybind11-dev python3-dev)")
  endif()
  message(STATUS "pybind11 not found (scripts/setup.sh test): the Python package is not built")
  set(FACET_BUILD_PYTHON OFF)
endif()
