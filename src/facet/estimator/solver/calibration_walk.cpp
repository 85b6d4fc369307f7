// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/calibration_walk.h"

#include <algorithm>

#include <Eigen/LU>

namespace facet {

// With W the covariance of the step and c the columns of the calibration, the Schur complement of
// the old one is H - H_c (I + W H_cc)^-1 W H_c^T, which needs no inverse of W.
void TakeRandomStep(const CalibrationMatrix& covariance, MarginalPrior& prior) {
  const auto block = std::find_if(prior.blocks.begin(), prior.blocks.end(), [](const auto& b) {
    return b.kind == Variable::Kind::kCalibration;
  });
  if (block == prior.blocks.end()) return;
  const Eigen::Matrix<double, Eigen::Dynamic, kNumCalibration> H_c =
      prior.H.middleCols<kNumCalibration>(block->offset);
  const CalibrationMatrix H_cc = H_c.middleRows<kNumCalibration>(block->offset);
  const CalibrationMatrix gain =
      (CalibrationMatrix::Identity() + covariance * H_cc).partialPivLu().solve(covariance);
  const CalibrationMatrix symmetric = 0.5 * (gain + gain.transpose());
  const CalibrationVector b_c = prior.b.segment<kNumCalibration>(block->offset);
  prior.b -= H_c * (symmetric * b_c);
  prior.H -= H_c * symmetric * H_c.transpose();
}

}  // namespace facet
