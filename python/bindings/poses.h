// SPDX-License-Identifier: BSD-2-Clause
// Poses as matrices of 4 x 4.
#pragma once

#include "arrays.h"

#include "facet/facet.h"

namespace facet::python {

Doubles PoseMatrix(const api::Pose& pose);

/// Throws ValueError for what is no rigid motion (within 1e-3).
api::Pose PoseFromMatrix(const py::object& matrix, const char* name);

}  // namespace facet::python
