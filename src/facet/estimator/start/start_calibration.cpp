// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/start/start_calibration.h"

#include <algorithm>
#include <cmath>

#include "facet/calibration/board_calibration.h"
#include "facet/calibration/calibration_groups.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

// As far as a rig's own covariance is trusted: it was another day.
constexpr double kOtherDay = 0.1;

CalibrationMatrix OfACarefulCalibration(const StereoRig& rig, const CalibrationOptions& options) {
  CalibrationMatrix covariance = CalibrationMatrix::Zero();
  BoardCalibrationOptions board;
  board.corner_noise_px = options.board_noise_px;
  if (const auto of_board = BoardCalibrationCovariance(rig, board))
    covariance.topLeftCorner<kNumRigParameters, kNumRigParameters>() = *of_board;
  const auto set = [&](int first, int count, double sigma) {
    covariance.diagonal().segment(first, count).setConstant(sigma * sigma);
  };
  const double per_axis = 1 / std::sqrt(3.0);
  const double per_mode = 1 / std::sqrt(static_cast<double>(kNumLensModes));
  set(kLensModes, 2 * kNumLensModes, per_mode * options.lens_misfit_px);
  set(kMountRotation, 3, per_axis * options.mount_rotation_deg * kDegree);
  set(kMountTranslation, 3, per_axis * options.mount_translation_m);
  set(kTimeOffset, 1, options.time_s);
  set(kGyroScale, 3, 0.01 * options.gyro_scale_percent);
  return covariance;
}

// What the former run held or did not have is as after a careful calibration.
CalibrationMatrix WithFormerRun(const CalibrationMatrix& careful, const CalibrationMatrix& former) {
  CalibrationMatrix covariance = kOtherDay * kOtherDay * careful + former;
  for (const auto& [first, size] : kCalibrationGroups) {
    if (!AreHeld(former, first, size)) continue;
    covariance.middleRows(first, size).setZero();
    covariance.middleCols(first, size).setZero();
    covariance.block(first, first, size, size) = careful.block(first, first, size, size);
  }
  return covariance;
}

}  // namespace

CalibrationMatrix StartCovariance(const StereoRig& rig, const CalibrationOptions& options) {
  CalibrationMatrix covariance = OfACarefulCalibration(rig, options);
  if (rig.covariance) covariance = WithFormerRun(covariance, *rig.covariance);
  const auto hold = [&](int first, int count) {
    covariance.middleRows(first, count).setZero();
    covariance.middleCols(first, count).setZero();
  };
  if (!options.lens) hold(0, kNumLensColumns);
  if (!options.mount) hold(kMountRotation, 6);
  if (!options.time) hold(kTimeOffset, 1);
  if (!options.gyro) hold(kGyroScale, 3);
  covariance.diagonal().array() += kHeldSigma * kHeldSigma;
  return covariance;
}

}  // namespace facet
