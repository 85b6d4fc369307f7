// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/calibration_care.h"

#include <algorithm>
#include <cmath>

#include "facet/calibration/believed_share.h"
#include "facet/estimator/solver/calibration_walk.h"
#include "facet/estimator/window/calibration_information.h"

namespace facet {
namespace {

// The prior is left alone for less than this share of a share.
constexpr double kWorthAChange = 0.1;
// Modes with less than this share are a hundredth of a pixel.
constexpr double kSmallShare = 0.05;

struct Columns {
  int first, count;
};
constexpr std::array<Columns, CalibrationCare::kNumGroups> kColumns = {
    {{kLensModes, 2 * kNumLensModes}, {0, kNumRigParameters}, {kMountRotation, 6}}};

auto BlockOf(const Columns& c, auto& matrix) {
  return matrix.block(c.first, c.first, c.count, c.count);
}

}  // namespace

CalibrationCare::CalibrationCare(const CalibrationMatrix& first, const CalibrationOptions& options)
    : first_(first), first_information_(InformationOf(first)), options_(options) {}

double CalibrationCare::Believed(Group group,
                                 const CalibrationVector& delta,
                                 const CalibrationMatrix& covariance) const {
  const Columns& c = kColumns[group];
  return BelievedShare(BlockOf(c, first_),
                       {delta.segment(c.first, c.count), BlockOf(c, covariance), shares_[group]});
}

// As what was measured is information beside the prior, a prior that becomes looser leaves it.
bool CalibrationCare::SetShare(Group group,
                               double share,
                               MarginalPrior& prior,
                               CalibrationMatrix& possible) {
  double& present = shares_[group];
  if (std::abs(share / present - 1) < kWorthAChange) return true;
  const Columns& c = kColumns[group];
  CalibrationMatrix change = CalibrationMatrix::Zero();
  BlockOf(c, change) = (1 / share - 1 / present) * BlockOf(c, first_information_);
  if (!AddInformation(change, prior)) return false;
  BlockOf(c, possible) *= share / present;
  present = share;
  return true;
}

void CalibrationCare::GiveUp(MarginalPrior& prior, CalibrationMatrix& possible) {
  for (const Group group : {kModesOfLenses, kLensesAndPair, kMount})
    SetShare(group, std::max(shares_[group], 1.0), prior, possible);
}

void CalibrationCare::CountLookAtModes(bool is_believed) {
  num_small_looks_ = is_believed && modes_share_ <= kSmallShare ? num_small_looks_ + 1 : 0;
  steps_at_last_look_ = steps_;
}

// Where a lens does much beside its model, its parameters were fitted to that, too: they are not
// better than what it does.
void CalibrationCare::Judge(const CalibrationVector& delta,
                            const CalibrationMatrix& covariance,
                            MarginalPrior& prior,
                            CalibrationMatrix& possible) {
  const auto believe = [&](Group group, double share) {
    return SetShare(group, share + steps_, prior, possible);
  };
  if (options_.lens) {
    if (!AreModesSettled()) {
      modes_share_ = Believed(kModesOfLenses, delta, covariance);
      CountLookAtModes(believe(kModesOfLenses, modes_share_));
    }
    believe(kLensesAndPair, std::max(modes_share_, Believed(kLensesAndPair, delta, covariance)));
  }
  if (options_.mount) believe(kMount, Believed(kMount, delta, covariance));
}

}  // namespace facet
