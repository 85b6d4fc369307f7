// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/calibration_vector.h"

#include "facet/geometry/so3.h"

namespace facet {

CalibrationVector CalibrationDifference(const StereoRig& from, const StereoRig& to) {
  CalibrationVector delta;
  delta.head<kNumRigParameters>() = ParameterDifference(from, to);
  for (std::size_t c = 0; c < 2; ++c)
    LensModesOf(delta, static_cast<int>(c)) = to.lens_modes[c] - from.lens_modes[c];
  const SE3 mount = to.T_BC[0] * from.T_BC[0].Inverse();
  delta.segment<3>(kMountRotation) = LogSO3(mount.q);
  delta.segment<3>(kMountTranslation) = mount.p;
  delta(kTimeOffset) = ToSeconds(to.time_offset) - ToSeconds(from.time_offset);
  delta.segment<3>(kGyroScale) = to.gyro_scale - from.gyro_scale;
  return delta;
}

void ForgetLensModes(CalibrationMatrix& covariance) {
  covariance.middleRows(kLensModes, 2 * kNumLensModes).setZero();
  covariance.middleCols(kLensModes, 2 * kNumLensModes).setZero();
}

bool SaysNothingOfLensModes(const CalibrationMatrix& covariance) {
  return covariance.diagonal().segment(kLensModes, 2 * kNumLensModes).isZero(0);
}

std::string WhatIsWrong(const CalibrationMatrix& of_all) {
  CalibrationMatrix covariance = of_all;
  if (SaysNothingOfLensModes(of_all))
    covariance.diagonal().segment(kLensModes, 2 * kNumLensModes).setOnes();
  const CalibrationVector scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const CalibrationMatrix correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  if (!((correlation - correlation.transpose()).cwiseAbs().maxCoeff() < 1e-6))
    return "a covariance is symmetric";
  if (!(covariance.diagonal().minCoeff() > 0) || correlation.ldlt().vectorD().minCoeff() <= 0)
    return "a covariance is positive definite";
  return "";
}

}  // namespace facet
