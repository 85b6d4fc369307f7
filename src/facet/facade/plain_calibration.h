// SPDX-License-Identifier: BSD-2-Clause
// Between the types of the library and those of facet/facet.h, for the parts of the facade and for
// what stands beside it (Python).
#pragma once

#include <string>

#include "facet/camera/stereo_rig.h"
#include "facet/facet.h"
#include "facet/geometry/se3.h"
#include "facet/imu/imu_types.h"

namespace facet::api {

/// Nothing that Odometry uses is lost: it gets the same numbers back.
Calibration PlainCalibration(const StereoRig& rig, const facet::ImuNoise& noise);

/// Throws Error, naming the pose, where it is not finite or its quaternion not of unit length.
SE3 Internal(const Pose& pose, const std::string& name);

}  // namespace facet::api
