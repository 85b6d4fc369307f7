// SPDX-License-Identifier: BSD-2-Clause
// The parts of the Python module facet._native, one source each.
#pragma once

#include <pybind11/pybind11.h>

namespace facet::python {

void BindErrors(pybind11::module_& module);
void BindCalibration(pybind11::module_& module);
void BindMesh(pybind11::module_& module);
void BindVio(pybind11::module_& module);
void BindRecording(pybind11::module_& module);
void BindTrajectory(pybind11::module_& module);
void BindCommands(pybind11::module_& module);

}  // namespace facet::python
