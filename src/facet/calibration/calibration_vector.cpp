// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/calibration_vector.h"

#include "facet/geometry/so3.h"

namespace facet {

CalibrationVector CalibrationDifference(const StereoRig& from, const StereoRig& to) {
  CalibrationVector delta;
  delta.head<kNumRigParameters>() = ParameterDifference(from, to);
  const SE3 mount = to.T_BC[0] * from.T_BC[0].Inverse();
  delta.segment<3>(kMountRotation) = LogSO3(mount.q);
  delta.segment<3>(kMountTranslation) = mount.p;
  delta(kTimeOffset) = ToSeconds(to.time_offset) - ToSeconds(from.time_offset);
  delta.tail<3>() = to.gyro_scale - from.gyro_scale;
  return delta;
}

}  // namespace facet
