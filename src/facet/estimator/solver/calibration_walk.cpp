// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/calibration_walk.h"

#include <algorithm>
#include <optional>

#include "facet/estimator/window/prior_walk.h"

namespace facet {
namespace {

/// The first column of the calibration; empty if the prior does not know it.
std::optional<int> CalibrationOffset(const MarginalPrior& prior) {
  const auto block = std::find_if(prior.blocks.begin(), prior.blocks.end(), [](const auto& b) {
    return b.kind == Variable::Kind::kCalibration;
  });
  if (block == prior.blocks.end()) return std::nullopt;
  return block->offset;
}

}  // namespace

bool KnowsCalibration(const MarginalPrior& prior) {
  return CalibrationOffset(prior).has_value();
}

bool TakeRandomStep(const CalibrationMatrix& covariance, MarginalPrior& prior) {
  const std::optional<int> offset = CalibrationOffset(prior);
  if (!offset) return false;
  TakeRandomStep<kNumCalibration>(*offset, covariance, prior);
  return true;
}

// The prior is a quadratic of the deviation from what was given: its gradient stays.
bool AddInformation(const CalibrationMatrix& information, MarginalPrior& prior) {
  const std::optional<int> offset = CalibrationOffset(prior);
  if (!offset) return false;
  prior.H.block<kNumCalibration, kNumCalibration>(*offset, *offset) += information;
  return true;
}

}  // namespace facet
