// SPDX-License-Identifier: BSD-2-Clause
// What a calibration of two cameras finds, as one vector of 22 numbers in this order: left fx fy cx
// cy and four coefficients of distortion, the right camera's eight, then rotation and translation
// of T_C1C0. A rotation is perturbed on the right, a translation is additive (docs/conventions.md).
#pragma once

#include <optional>

#include "facet/camera/stereo_rig.h"

namespace facet {

using RigVector = Vector<kNumRigParameters>;
using RigMatrix = Matrix<kNumRigParameters, kNumRigParameters>;

/// The rig with its parameters changed by `delta`. The left camera stays where it is in the body.
/// Empty if a camera would no longer be usable (CameraModel::WhatIsWrong).
std::optional<StereoRig> ChangeParameters(const StereoRig& rig, const RigVector& delta);

/// The `delta` that ChangeParameters turns `from` into `to` with, but for where the rig is in the
/// body. Both have the same models of distortion.
RigVector ParameterDifference(const StereoRig& from, const StereoRig& to);

}  // namespace facet
