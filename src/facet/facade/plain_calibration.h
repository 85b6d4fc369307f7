// SPDX-License-Identifier: BSD-2-Clause
// From the types of the library to those of facet/facet.h, for what stands beside the facade
// (Python).
#pragma once

#include "facet/camera/stereo_rig.h"
#include "facet/facet.h"
#include "facet/imu/imu_types.h"

namespace facet::api {

/// Nothing that Odometry uses is lost: it gets the same numbers back.
Calibration PlainCalibration(const StereoRig& rig, const facet::ImuNoise& noise);

}  // namespace facet::api
