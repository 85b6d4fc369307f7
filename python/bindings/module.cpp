// SPDX-License-Identifier: BSD-2-Clause
#include "bindings.h"

#include "facet/facet.h"

PYBIND11_MODULE(_native, module) {
  module.doc() = "The part of the package facet that is C++; use the names of facet instead.";
  module.attr("__version__") = facet::api::Version();
  facet::python::BindErrors(module);
  facet::python::BindCalibration(module);
  facet::python::BindMesh(module);
  facet::python::BindVio(module);
  facet::python::BindRecording(module);
  facet::python::BindTrajectory(module);
  facet::python::BindCommands(module);
}
