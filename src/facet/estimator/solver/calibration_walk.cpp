// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/calibration_walk.h"

#include <algorithm>

#include "facet/estimator/window/prior_walk.h"

namespace facet {

bool TakeRandomStep(const CalibrationMatrix& covariance, MarginalPrior& prior) {
  const auto block = std::find_if(prior.blocks.begin(), prior.blocks.end(), [](const auto& b) {
    return b.kind == Variable::Kind::kCalibration;
  });
  if (block == prior.blocks.end()) return false;
  TakeRandomStep<kNumCalibration>(block->offset, covariance, prior);
  return true;
}

}  // namespace facet
