// SPDX-License-Identifier: BSD-2-Clause
// How wrong a calibration is, given the true one.
#pragma once

#include <optional>

#include "facet/calibration/calibration_vector.h"

namespace facet {

struct CalibrationError {
  CalibrationVector error;  ///< of the estimate, in the order of CalibrationVector
  /// Of the right pixel of a point at infinity, given its left pixel, over the part of the left
  /// image that the right one shows: mean and root mean square along the rows, and the latter
  /// across them.
  double disparity_mean_px = 0, disparity_rms_px = 0, vertical_rms_px = 0;
  /// Squared errors over the stated covariance, per parameter; groups that were held do not count.
  /// Empty without a covariance, or if all were held.
  std::optional<double> nees;
};

/// The models of distortion must be the same.
CalibrationError CompareCalibrations(const StereoRig& estimate, const StereoRig& truth);

}  // namespace facet
