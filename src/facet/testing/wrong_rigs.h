// SPDX-License-Identifier: BSD-2-Clause
// For tests: rigs whose calibration is wrong by a factor.
#pragma once

#include "facet/camera/stereo_rig.h"

namespace facet::testing {

/// The right camera is so many times as far from the left one.
inline StereoRig WithBaseline(StereoRig rig, double factor) {
  const Vector3d left = rig.T_BC[0].p;
  rig.T_BC[1].p = left + factor * (rig.T_BC[1].p - left);
  return rig;
}

/// Both cameras.
inline StereoRig WithFocalLengths(StereoRig rig, double factor) {
  for (CameraModel& camera : rig.cameras) {
    CameraIntrinsics k = camera.intrinsics();
    k.fx *= factor;
    k.fy *= factor;
    camera = CameraModel(k);
  }
  return rig;
}

}  // namespace facet::testing
