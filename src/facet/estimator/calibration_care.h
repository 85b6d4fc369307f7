// SPDX-License-Identifier: BSD-2-Clause
// How careful the calibration was, as the run shows: parts of it that turn out to be better than a
// careful calibration leaves are believed more (docs/math.md, section 10.10).
#pragma once

#include <array>

#include "facet/calibration/calibration_vector.h"
#include "facet/estimator/estimator_options.h"
#include "facet/estimator/window/window_priors.h"

namespace facet {

/// Not thread-safe.
class CalibrationCare {
 public:
  /// What was calibrated together, with the same care.
  enum Group { kModesOfLenses, kLensesAndPair, kMount, kNumGroups };

  /// `first`: before any measurement; what lenses do beside their models, lenses with the stereo
  /// pair, and the mount have nothing in common.
  CalibrationCare(const CalibrationMatrix& first, const CalibrationOptions& options);

  /// `delta` and `covariance`: what is known of the calibration by now. Each group's part of the
  /// prior becomes as tight as that group is believed to have been calibrated, or as loose again,
  /// and so does `possible`, the covariance of what was known before any measurement. Nothing if
  /// the prior does not know the calibration.
  void Judge(const CalibrationVector& delta,
             const CalibrationMatrix& covariance,
             MarginalPrior& prior,
             CalibrationMatrix& possible);

  /// For some seconds what the lenses do beside their models has been nearly nothing: it needs no
  /// measurements until random steps have added up to something.
  bool AreModesSettled() const { return num_small_looks_ >= kLooksToSettle; }

  /// The prior has taken a random step with this share of the first covariance. That stays.
  void AddStep(double share) {
    steps_ += share;
    for (double& s : shares_)
      s += share;
    if (AreModesSettled() && steps_ - steps_at_last_look_ > kWorthALook) num_small_looks_ = 0;
  }

  /// The calibration has turned out to be worse than a careful one: nothing is believed more than
  /// it was at first.
  void GiveUp(MarginalPrior& prior, CalibrationMatrix& possible);

 private:
  static constexpr int kLooksToSettle = 5;
  static constexpr double kWorthALook = 0.05;  // share of the first variance

  void CountLookAtModes(bool is_believed);
  double Believed(Group group,
                  const CalibrationVector& delta,
                  const CalibrationMatrix& covariance) const;
  /// False if the prior does not know the calibration.
  bool SetShare(Group group, double share, MarginalPrior& prior, CalibrationMatrix& possible);

  CalibrationMatrix first_, first_information_;
  CalibrationOptions options_;
  double steps_ = 0;                                   // the sum of all random steps
  std::array<double, kNumGroups> shares_ = {1, 1, 1};  // of the first variances, in the prior now

  double modes_share_ = 1;         // as it was believed last
  int num_small_looks_ = 0;        // at the modes, in turn
  double steps_at_last_look_ = 0;  // at the modes
};

}  // namespace facet
