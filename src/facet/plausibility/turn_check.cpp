// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/turn_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace facet {
namespace {

constexpr std::size_t kRowsPerTurn = 3;
// The least before anything is said, how often it is said anew, and after how many nothing more is
// to be learnt.
constexpr std::size_t kLeastTurns = 20, kTurnsPerFit = 10, kMostTurns = 300;
constexpr int kDoubtsInARow = 2;
// Careful calibrations and drawn ones leave 0.2 %, and so do gyroscopes that were calibrated.
constexpr double kLeastDoubt = 0.005, kSureSigmas = 4;
// Of the matrix between the turns of both sides, from the identity, where the axes are the same.
constexpr double kMostOff = 0.5;
// What the estimator leaves of the gyroscope's bias [rad/s]; errors of the lens are the same in
// turns that are alike.
constexpr LineNoise kNoise = {0.01, 1.5};

}  // namespace

bool TurnCheck::IsDone() const {
  return rows_.size() >= kRowsPerTurn * kMostTurns;
}

bool TurnCheck::Add(const DoubleTurn& turn) {
  if (IsDone()) return false;
  for (int axis = 0; axis < 3; ++axis)
    rows_.push_back({axis, turn.by_images(axis), turn.by_gyro, turn.dt_s * Vector3d::Unit(axis)});
  const std::size_t num_turns = rows_.size() / kRowsPerTurn;
  if (num_turns < kLeastTurns || num_turns % kTurnsPerFit != 0) return false;
  ratio_ = Fit();
  do_axes_agree_ = do_axes_agree_ || FindWhetherAxesAgree();
  num_doubts_ = ratio_ && ratio_->IsOff(kLeastDoubt, kSureSigmas) ? num_doubts_ + 1 : 0;
  if (has_doubted_ || num_doubts_ < kDoubtsInARow) return false;
  has_doubted_ = true;
  return true;
}

std::optional<TurnCheck::Ratio> TurnCheck::Fit() const {
  return FitFactor(
      rows_,
      [](const Row& row) { return row.by_gyro(row.axis); },
      [](const Row& row) { return row.by_images; },
      kNoise);
}

bool TurnCheck::FindWhetherAxesAgree() const {
  std::vector<Row> rows;
  for (int axis = 0; axis < 3; ++axis) {
    rows.clear();
    std::copy_if(rows_.begin(), rows_.end(), std::back_inserter(rows), [&](const Row& row) {
      return row.axis == axis;
    });
    const auto line = FitLine<3>(
        rows,
        [](const Row& row) { return row.by_gyro; },
        [](const Row& row) { return row.by_images; },
        kNoise);
    if (!line) return false;
    const Vector3d off = (line->slope - Vector3d::Unit(axis)).cwiseAbs();
    if ((off + kSureSigmas * line->sigma).maxCoeff() > kMostOff) return false;
  }
  return true;
}

std::string TurnsInWords(const TurnCheck::Ratio& ratio) {
  char text[400];
  std::snprintf(text,
                sizeof(text),
                "the images turn by %.2f %% (1-sigma %.2f) %s than the gyroscope says: check the "
                "focal lengths (are they of this resolution?) and the gyroscope's scale",
                100 * std::abs(ratio.value() - 1),
                100 * ratio.sigma,
                ratio.value() > 1 ? "more" : "less");
  return text;
}

}  // namespace facet
