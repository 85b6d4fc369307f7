// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/start/start_calibration.h"

#include <algorithm>
#include <cmath>

#include "facet/calibration/board_calibration.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

// 1-sigma of what is held, in the units of the parameter: far below what anything can measure.
constexpr double kHeldSigma = 1e-7;

}  // namespace

CalibrationMatrix StartCovariance(const StereoRig& rig, const CalibrationOptions& options) {
  CalibrationMatrix covariance = CalibrationMatrix::Zero();
  if (options.lens) {
    BoardCalibrationOptions board;
    board.corner_noise_px = options.board_noise_px;
    if (const auto of_board = BoardCalibrationCovariance(rig, board))
      covariance.topLeftCorner<kNumRigParameters, kNumRigParameters>() = *of_board;
  }
  const auto set = [&](int first, int count, bool is_estimated, double sigma) {
    if (is_estimated) covariance.diagonal().segment(first, count).setConstant(sigma * sigma);
  };
  const double per_axis = 1 / std::sqrt(3.0);
  set(kMountRotation, 3, options.mount, per_axis * options.mount_rotation_deg * kDegree);
  set(kMountTranslation, 3, options.mount, per_axis * options.mount_translation_m);
  set(kTimeOffset, 1, options.time, options.time_s);
  covariance.diagonal().array() += kHeldSigma * kHeldSigma;
  return covariance;
}

}  // namespace facet
