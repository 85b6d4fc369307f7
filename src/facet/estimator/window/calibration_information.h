// SPDX-License-Identifier: BSD-2-Clause
// From the covariance of a calibration to what is known of it.
#pragma once

#include <Eigen/Cholesky>

#include "facet/calibration/calibration_vector.h"

namespace facet {

/// The inverse; variances may span many orders of magnitude.
inline CalibrationMatrix InformationOf(const CalibrationMatrix& covariance) {
  const CalibrationVector scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const CalibrationMatrix correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const CalibrationMatrix inverse = correlation.llt().solve(CalibrationMatrix::Identity());
  return scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal();
}

}  // namespace facet
